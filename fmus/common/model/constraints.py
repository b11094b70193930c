"""The constraint set D(x~) in the paper's own form.

x~ (37) = theta (6), lam_Q1 ... lam_Q6 (4 each), x_E (3), lam_E (4); d is all but theta.
`tests/common/dense_form.py` solves it densely; `linkage.py` must equal that to rounding.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca

from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.model import quaternion as qn
from flexhex.fmus.common.model.geometry import ArmFrame, Frames

N_LAM = 4


@dataclass(frozen=True)
class Coordinates:
    """x~ taken apart: theta (n,), lam_Q (4, n), x_E (3,), lam_E (4,)."""

    theta: ca.SX
    lam_Q: list[ca.SX]
    x_E: ca.SX
    lam_E: ca.SX

    @staticmethod
    def split(x: ca.SX, n: int = 6) -> Coordinates:
        """Take x~ (n + 4 n + 7,) apart; (n,) without a platform."""
        if x.numel() == n:
            return Coordinates(x, [], ca.SX(0, 1), ca.SX(0, 1))
        lam_Q = [x[n + N_LAM * i : n + N_LAM * (i + 1)] for i in range(n)]
        tail = n + N_LAM * n
        return Coordinates(x[:n], lam_Q, x[tail : tail + 3], x[tail + 3 : tail + 7])


def relative_universal(arm: ArmFrame, turn: ca.SX, lam_Q: ca.SX) -> ca.SX:
    """q (4,): Q against B, (1, 0, 0, 0) at neutral. Bends about y, z; its twist is zero.

    turn (4,): quaternion of the upper arm's rotation by theta.
    """
    lam_BC = qn.mul(turn, ca.SX(arm.lam_Q0))
    return qn.mul(qn.conj(lam_BC), lam_Q)


def relative_spherical(arm: ArmFrame, lam_E: ca.SX, lam_Q: ca.SX) -> ca.SX:
    """s (4,): Q against E, (1, 0, 0, 0) at neutral."""
    return qn.mul(qn.conj(qn.mul(lam_E, ca.SX(arm.S))), lam_Q)


def deformations(q: ca.SX) -> ca.SX:
    """(eps_x, eps_y, eps_z) = 2 q0 (q1, q2, q3) [rad].  [SH, Eq. (18), ref. 9]

    Half the antisymmetric part of the relative rotation matrix, the bending and twist
    measures of Schwab & Meijaard: sine of the angle for a rotation about one axis. x lies
    along the lower arm, so the twist comes first; [SH, Eq. (5a)] counts it third, eps_u3.
    """
    return 2 * q[0] * q[1:4]


def constraints(machine: Machine, frames: Frames, x: ca.SX) -> ca.SX:
    """D(x~) (31,): per arm twist, |lam_Q|^2 - 1, closure (3) [m]; then |lam_E|^2 - 1.

    [SH, Eq. (5), (6)]; (5c) is printed |lam| = 0, what holds is lam^T lam - 1 = 0.
    """
    xt = Coordinates.split(x, machine.n_arms)
    r_BQ, r_QP = machine.geometry.L, ca.vertcat(machine.platform.l, 0, 0)
    rows = []
    for i, arm in enumerate(frames.arms):
        lam_Q, theta = xt.lam_Q[i], xt.theta[i]
        turn = qn.about(ca.SX(arm.axis), theta)
        q = relative_universal(arm, turn, lam_Q)
        u = qn.rotation(turn) @ ca.SX(arm.u_B)
        closure = (
            xt.x_E
            + qn.rotation(xt.lam_E) @ ca.SX(arm.r_EP)
            - ca.SX(arm.x_B)
            - r_BQ * u
            - qn.rotation(lam_Q) @ r_QP
        )
        rows += [deformations(q)[0], ca.dot(lam_Q, lam_Q) - 1, closure]
    return ca.vertcat(*rows, ca.dot(xt.lam_E, xt.lam_E) - 1)

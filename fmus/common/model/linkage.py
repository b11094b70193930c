"""The closed loops solved by structure: the exact result of D_d^-1 with one 6 x 6 solve.

The 31 x 31 system D_d delta_d = b of [SH, Eq. (14), (17), (29)] falls apart when each
quaternion is moved by delta_lam = lam y (quaternion product, y = (y0, y1, y2, y3)):
the norm row gives y0 at once; the closure rows, seen in the axes of Q_i, give y2 and y3
from the motion of P_i; the twist row gives y1. What remains for each arm is its closure
row along the lower arm, which holds the platform alone: six equations for the six
freedoms of E. No approximation is made: the result equals the dense solve to rounding,
also where |lam| differs from one during the Newton iteration.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca

from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.machine.sections import Arm
from flexhex.fmus.common.model import quaternion as qn
from flexhex.fmus.common.model.constraints import (
    Coordinates,
    deformations,
    relative_spherical,
    relative_universal,
)
from flexhex.fmus.common.model.geometry import ArmFrame, Frames
from flexhex.fmus.common.model.solve import RowFactor, reciprocal


@dataclass(frozen=True)
class ArmRhs:
    """Right-hand side of one arm's five constraint rows: twist, norm, closure (3,)."""

    twist: ca.SX
    norm: ca.SX
    closure: ca.SX


def half_angles(theta: ca.SX) -> ca.SX:
    """Cosine and sine of the half angles (2, n), all that a pose needs of theta (n,)."""
    return ca.horzcat(ca.cos(theta / 2), ca.sin(theta / 2)).T


class UpperPose:
    """The upper arm of an arm: u (3,), unit vector along it, and up = du/dtheta.

    turn (4,): quaternion of its rotation by theta; half (2,): its column of `half_angles`.
    """

    def __init__(self, arm: Arm | ArmFrame, half: ca.SX) -> None:
        self.turn = ca.vertcat(half[0], half[1] * ca.SX(arm.axis))
        sine, cosine = 2 * half[0] * half[1], 1 - 2 * half[1] ** 2
        u0, side = ca.SX(arm.u_B), ca.cross(ca.SX(arm.axis), ca.SX(arm.u_B))
        self.u, self.up = cosine * u0 + sine * side, cosine * side - sine * u0


class ArmPose(UpperPose):
    """Everything about an arm that depends on the pose alone; lam_Q (4,), lam_E (4,).

    R_Q = R(lam_Q); n_Q = |lam_Q|^2; per_n_Q = 1 / n_Q;
    q, s (4,): relative quaternions of the universal and spherical joint; per_twist: what a twist
    takes of y1, 1 / (q0^2 - q1^2); beta: motion of P_i along the lower arm for a unit joint
    rate, R_Q[:, 0] . L up. One division for each reciprocal.
    """

    def __init__(self, arm: ArmFrame, lam_Q: ca.SX, lam_E: ca.SX, half: ca.SX) -> None:
        super().__init__(arm, half)
        self.arm, self.L, self.l = arm, arm.L, arm.l
        self.lam_Q = lam_Q
        self.R_Q = qn.rotation(self.lam_Q)
        self.n_Q = ca.dot(self.lam_Q, self.lam_Q)
        self.q = relative_universal(arm, self.turn, self.lam_Q)
        self.s = relative_spherical(arm, lam_E, self.lam_Q)
        self.per_n_Q = reciprocal(self.n_Q)
        self.per_twist = reciprocal(self.q[0] ** 2 - self.q[1] ** 2)
        self.beta = self.L * ca.dot(self.R_Q[:, 0], self.up)

    def closure(self, xt: Coordinates, R_E: ca.SX) -> ca.SX:
        """Closure error at P_i (3,) [m]."""
        reach = xt.x_E + R_E @ ca.SX(self.arm.r_EP) - ca.SX(self.arm.x_B)
        return reach - self.L * self.u - self.l * self.R_Q[:, 0]

    def twist_rate(self) -> ca.SX:
        """d eps / d theta of the twist: eps_u3 in [SH, Eq. (5a)], deformations(q)[0] here, as x
        of Q lies along the lower arm."""
        qv, a = self.q[1:4], ca.SX(self.arm.a_Q)
        q0_rate, q1_rate = ca.dot(a, qv) / 2, -(self.q[0] * a[0] + ca.cross(a, qv)[0]) / 2
        return 2 * (q0_rate * self.q[1] + self.q[0] * q1_rate)

    def solve_rod(self, rhs: ArmRhs, delta_P: ca.SX) -> ca.SX:
        """y (4,) of the lower arm from its constraint rows and the motion of P_i (3,)."""
        q, scale = self.q, self.per_n_Q**2 / (2 * self.l)
        y0 = rhs.norm / 2 * self.per_n_Q
        across = self.R_Q[:, 1:3].T @ (delta_P - rhs.closure)
        y2, y3 = -across[1] * scale, across[0] * scale
        twist = rhs.twist / 2 - 2 * q[0] * q[1] * y0
        twist = twist + (q[1] * q[2] + q[0] * q[3]) * y2 - (q[0] * q[2] - q[1] * q[3]) * y3
        return ca.vertcat(y0, twist * self.per_twist, y2, y3)


class Linkage:
    """The mechanism at one pose x~, ready to solve for any right-hand side.

    half (2, n): `half_angles` of the pose.
    """

    def __init__(self, frames: Frames, x: ca.SX, half: ca.SX) -> None:
        self.n = len(frames.arms)
        self.xt = Coordinates.split(x, self.n)
        self.R_E = qn.rotation(self.xt.lam_E)
        self.n_E = ca.dot(self.xt.lam_E, self.xt.lam_E)
        self.per_n_E = reciprocal(self.n_E)
        self.arms = [
            ArmPose(arm, self.xt.lam_Q[i], self.xt.lam_E, half[:, i])
            for i, arm in enumerate(frames.arms)
        ]
        rows = []
        for pose in self.arms:
            rod = pose.R_Q[:, 0]
            rows.append(ca.horzcat(rod.T, ca.cross(ca.SX(pose.arm.r_EP), self.R_E.T @ rod).T))
        self.platform = RowFactor.of(ca.vertcat(*rows))

    def residual(self) -> ca.SX:
        """D(x~) (31,), in the order of `constraints`."""
        rows = []
        for pose in self.arms:
            rows += [deformations(pose.q)[0], pose.n_Q - 1, pose.closure(self.xt, self.R_E)]
        return ca.vertcat(*rows, self.n_E - 1)

    def solve(self, b: ca.SX) -> ca.SX:
        """delta_d (31,) of D_d delta_d = b."""
        rhs = [ArmRhs(b[5 * i], b[5 * i + 1], b[5 * i + 2 : 5 * i + 5]) for i in range(self.n)]
        y_E0 = b[5 * self.n] / 2 * self.per_n_E
        grown = [2 * y_E0 * (self.R_E @ ca.SX(pose.arm.r_EP)) for pose in self.arms]
        along = []
        for pose, right, growth in zip(self.arms, rhs, grown, strict=True):
            stretch = right.norm * pose.l * pose.n_Q
            along.append(stretch + ca.dot(pose.R_Q[:, 0], right.closure - growth))
        move = self.platform.solve(ca.vertcat(*along))
        delta_x, turn = move[:3], move[3:]
        parts = []
        for pose, right, growth in zip(self.arms, rhs, grown, strict=True):
            delta_P = delta_x + self.R_E @ ca.cross(turn, ca.SX(pose.arm.r_EP)) + growth
            parts.append(qn.mul(pose.lam_Q, pose.solve_rod(right, delta_P)))
        delta_E = qn.mul(self.xt.lam_E, ca.vertcat(y_E0, turn / 2))
        return ca.vertcat(*parts, delta_x, delta_E)

    def newton(self) -> ca.SX:
        """d (31,) after one correction, d - D_d^-1 D.  [SH, Eq. (29)]"""
        xt = self.xt
        return ca.vertcat(*xt.lam_Q, xt.x_E, xt.lam_E) - self.solve(self.residual())

    def rates(self, thetad: ca.SX) -> ca.SX:
        """xd (37,) = J thetad.  [SH, Eq. (14), (15)]"""
        return ca.vertcat(thetad, self.solve(-self._theta_rows(thetad)))

    def accelerations(self, xd: ca.SX, thetadd: ca.SX) -> ca.SX:
        """xdd (37,) = J thetadd + gamma.  [SH, Eq. (16), (17); IV-E prints (17) for (16)]"""
        b = -self._theta_rows(thetadd) - self._curvature(Coordinates.split(xd, self.n))
        return ca.vertcat(thetadd, self.solve(b))

    def _theta_rows(self, rate: ca.SX) -> ca.SX:
        """D_theta rate (31,)."""
        rows: list[ca.SX] = []
        for i, pose in enumerate(self.arms):
            rows += [pose.twist_rate() * rate[i], ca.SX(0), -pose.L * pose.up * rate[i]]
        return ca.vertcat(*rows, 0)

    def _curvature(self, v: Coordinates) -> ca.SX:
        """sum_jk d2D/dx_j dx_k xd_j xd_k (31,).  [SH, Eq. (9) with its correction, (17)]"""
        rows = []
        R_Ed = qn.rotation(v.lam_E)
        for i, pose in enumerate(self.arms):
            thetad, lamd = v.theta[i], v.lam_Q[i]
            # q = Lam lam with Lam(theta): q' = Lam' lam + Lam lam', q'' = Lam'' lam + 2 Lam' lam'
            half_a = qn.pure(-ca.SX(pose.arm.a_Q) / 2 * thetad)
            carried = relative_universal(pose.arm, pose.turn, lamd)
            qd = qn.mul(half_a, pose.q) + carried
            qdd = -(thetad**2) / 4 * pose.q + 2 * qn.mul(half_a, carried)
            twist = 2 * (qdd[0] * pose.q[1] + 2 * qd[0] * qd[1] + pose.q[0] * qdd[1])
            closure = (
                2 * (R_Ed @ ca.SX(pose.arm.r_EP))
                + pose.L * thetad**2 * pose.u
                - 2 * pose.l * qn.rotation(lamd)[:, 0]
            )
            rows += [twist, 2 * ca.dot(lamd, lamd), closure]
        return ca.vertcat(*rows, 2 * ca.dot(v.lam_E, v.lam_E))


class FreeArms:
    """Upper arms without a platform: nothing to close, x~ = theta. Serves like a `Linkage`."""

    def __init__(self, machine: Machine, half: ca.SX) -> None:
        self.n = machine.n_arms
        self.arms = [UpperPose(arm, half[:, i]) for i, arm in enumerate(machine.arms)]

    def residual(self) -> ca.SX:
        """No constraints (0,)."""
        return ca.SX(0, 1)

    def newton(self) -> ca.SX:
        """No dependent coordinates (0,)."""
        return ca.SX(0, 1)

    def rates(self, thetad: ca.SX) -> ca.SX:
        """xd (6,) = thetad."""
        return thetad

    def accelerations(self, xd: ca.SX, thetadd: ca.SX) -> ca.SX:
        """xdd (6,) = thetadd."""
        return thetadd

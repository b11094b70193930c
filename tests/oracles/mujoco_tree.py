"""The mechanism as an open MuJoCo tree: its inverse dynamics, projected by our own loop closure.

Joints of the tree, in order: for each arm a hinge (upper arm) and a ball joint (lower arm),
then a free joint (end-effector): 6 (1 + 3) + 6 = 30 velocities. A ball joint's velocity
is the angular velocity of the child against its parent in the child's frame; a free joint's
is the linear velocity of the origin in the world and the angular velocity in the body.
"""

from __future__ import annotations

import mujoco
import numpy as np

from tests.oracles.calculus import Array, taylor
from tests.oracles.geometry import circle, close, conjugate, multiply, quaternion, split
from tests.oracles.machine import Body, Machine

N_V = 30


class MujocoTree:
    """Inverse dynamics of one machine without flexures and actuators."""

    def __init__(self, machine: Machine) -> None:
        self.machine = machine
        self.lam_B0 = quaternion(machine.R_B0)
        self.lam_C = quaternion(np.swapaxes(machine.R_B0, -1, -2) @ machine.R_Q0)
        self.model = mujoco.MjModel.from_xml_string(_mjcf(machine, self.lam_B0, self.lam_C))
        self.data = mujoco.MjData(self.model)

    def state(self, theta: Array, thetad: Array, thetadd: Array) -> tuple[Array, Array, Array]:
        """qpos (37,), qvel (30,), qacc (30,) of the closed mechanism, by Taylor coefficients."""

        def path(s: Array) -> Array:
            s = s[:, None]
            return self._qpos(close(self.machine, theta + s * thetad + s * s / 2 * thetadd))

        c = taylor(path, 2, *circle(thetad, thetadd))
        q, qd, qdd = c[0].real, c[1].real, 2 * c[2].real
        return q, self._velocity(q, qd), self._velocity(q, qdd)

    def projection(self, qpos: Array) -> Array:
        """V (30, 6): velocities of the tree for unit joint rates with all loops closed.

        Null space of the 24 constraints on MuJoCo's own Jacobians: the gap at each P and the
        rate of the quaternion twist 2 q0 q1 of each universal joint.
        """
        A = np.vstack([self._gap_jacobian(qpos), self._twist_jacobian(qpos)])
        theta = np.arange(6) * 4
        rest = np.setdiff1d(np.arange(N_V), theta)
        V = np.zeros((N_V, 6))
        V[theta] = np.eye(6)
        V[rest] = -np.linalg.solve(A[:, rest], A[:, theta])
        return V

    def inverse_dynamics(self, theta: Array, thetad: Array, thetadd: Array) -> Array:
        """Torque (6,) [N m] of inertia and gravity."""
        qpos, qvel, qacc = self.state(theta, thetad, thetadd)
        self.data.qpos[:], self.data.qvel[:], self.data.qacc[:] = qpos, qvel, qacc
        mujoco.mj_inverse(self.model, self.data)
        force: Array = np.array(self.data.qfrc_inverse)
        return self.projection(qpos).T @ force

    def _qpos(self, x: Array) -> Array:
        theta, lam_Q, x_E, lam_E = split(x)
        half = theta[..., None] / 2
        turn = np.concatenate([np.cos(half), np.sin(half) * self.machine.axis], axis=-1)
        carried = multiply(multiply(turn, self.lam_B0), self.lam_C)
        q = multiply(conjugate(carried), lam_Q)
        arms = np.concatenate([theta[..., None], q], axis=-1)
        return np.concatenate([arms.reshape(*x.shape[:-1], 30), x_E, lam_E], axis=-1)

    def _velocity(self, q: Array, rate: Array) -> Array:
        """Velocity (30,) for a rate (37,) of qpos; for its second derivative, the acceleration.

        2 conj(q) qd = (0, w). Its derivative is 2 conj(q) qdd + 2 conj(qd) qd, whose second
        term has no vector part: the same formula gives both.
        """
        v = np.zeros(N_V)
        for i in range(6):
            v[4 * i] = rate[5 * i]
            quat = slice(5 * i + 1, 5 * i + 5)
            v[4 * i + 1 : 4 * i + 4] = 2 * multiply(conjugate(q[quat]), rate[quat])[1:]
        v[24:27] = rate[30:33]
        v[27:] = 2 * multiply(conjugate(q[33:]), rate[33:])[1:]
        return v

    def _gap_jacobian(self, qpos: Array) -> Array:
        self.data.qpos[:] = qpos
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_comPos(self.model, self.data)
        rows = []
        for i in range(6):
            ends = []
            for site in (f"P{i}", f"E{i}"):
                jac = np.zeros((3, N_V))
                mujoco.mj_jacSite(self.model, self.data, jac, None, self.model.site(site).id)
                ends.append(jac)
            rows.append(ends[1] - ends[0])
        return np.vstack(rows)

    def _twist_jacobian(self, qpos: Array) -> Array:
        A = np.zeros((6, N_V))
        for i in range(6):
            q = qpos[5 * i + 1 : 5 * i + 5]
            for k in range(3):
                qd = multiply(q, np.eye(4)[k + 1]) / 2
                A[i, 4 * i + 1 + k] = 2 * (qd[0] * q[1] + q[0] * qd[1])
        return A


def _mjcf(machine: Machine, lam_B0: Array, lam_C: Array) -> str:
    """MJCF text of the tree; contacts, constraints, springs, dampers and actuators are off."""
    arms = []
    for i in range(6):
        axis_B = machine.R_B0[i].T @ machine.axis[i]
        arms.append(
            f'<body pos="{_text(machine.x_B[i])}" quat="{_text(lam_B0[i])}">'
            f'<joint type="hinge" axis="{_text(axis_B)}" armature="{machine.J_rotor!r}"/>'
            f"{_inertial(machine.upper)}"
            f'<body pos="{machine.L!r} 0 0" quat="{_text(lam_C[i])}"><joint type="ball"/>'
            f'{_inertial(machine.lower)}<site name="P{i}" pos="{machine.l!r} 0 0"/></body></body>'
        )
    sites = "".join(f'<site name="E{i}" pos="{_text(r)}"/>' for i, r in enumerate(machine.r_EP))
    return (
        f'<mujoco><compiler angle="radian" autolimits="false"/>'
        f'<option gravity="{_text(machine.g)}">'
        '<flag constraint="disable" contact="disable" spring="disable" damper="disable"'
        ' actuation="disable"/></option>'
        f'<worldbody>{"".join(arms)}<body pos="{_text(machine.x_E0)}"><freejoint/>'
        f"{_inertial(machine.end_effector)}{sites}</body></worldbody></mujoco>"
    )


def _inertial(body: Body) -> str:
    xx, xy, xz, _, yy, yz, _, _, zz = body.Ic.ravel()
    six = _text(np.array([xx, yy, zz, xy, xz, yz]))
    return f'<inertial mass="{body.m!r}" pos="{_text(body.c)}" fullinertia="{six}"/>'


def _text(values: Array) -> str:
    return " ".join(repr(float(v)) for v in values)

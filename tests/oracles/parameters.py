"""The 162 parameters of a machine, worked out by hand from its bodies.

The lower arm's m and mc_x cannot be seen apart from its neighbours: two point masses on the
rod, m - mc_x / l at Q and mc_x / l at P, have the same m and mc_x, and a mass at Q moves with
the upper arm, one at P with the end-effector. What is left of the lower arm has no mass.
"""

from __future__ import annotations

import numpy as np

from tests.oracles.calculus import Array
from tests.oracles.machine import Body, Machine


def base_parameters(machine: Machine) -> Array:
    """p (162,): joints (22 each), upper arms (6 + 2), lower arm (8), platform (10), k (4)."""
    lower, upper, platform = machine.lower, machine.upper, machine.end_effector
    m_P = lower.m * lower.c[0] / machine.l
    m_Q = lower.m - m_P

    J_B = upper.J[1, 1] + machine.J_rotor + m_Q * machine.L**2
    upper_mc_x = upper.m * upper.c[0] + m_Q * machine.L
    upper_mc_z = upper.m * upper.c[2]

    J_Q = lower.J - m_P * machine.l**2 * np.diag([0.0, 1.0, 1.0])

    r = machine.r_EP
    J_E = platform.J + m_P * (np.sum(r * r) * np.eye(3) - r.T @ r)
    mc_E = platform.m * platform.c + m_P * np.sum(r, axis=0)

    return np.concatenate(
        [
            _actuators(machine),
            np.full(6, J_B),
            [upper_mc_x, upper_mc_z],
            lower.m * lower.c[1:],
            _six(J_Q),
            [platform.m + 6 * m_P],
            mc_E,
            _six(J_E),
            machine.k_u,
            machine.k_s,
        ]
    )


def _six(J: Array) -> Array:
    return np.array([J[0, 0], J[1, 1], J[2, 2], J[0, 1], J[0, 2], J[1, 2]])


def _actuators(machine: Machine) -> Array:
    act = machine.actuator
    pairs = np.stack([act.a, act.b], axis=-1).reshape(6, -1)
    return np.concatenate([np.stack([act.o, act.k, act.d, act.c], axis=-1), pairs], axis=1).ravel()


def full_mechanism(machine: Machine) -> Array:
    """The plant's 112 values, nothing regrouped: per arm upper J, mc_x, mc_z, lower arm (10)
    and stiffness (4), then the end-effector (10); a body is m, mc (3), J (6) about its origin.
    """
    upper, k = machine.upper, np.concatenate([machine.k_u, machine.k_s])
    axial = [upper.J[1, 1] + machine.J_rotor, upper.m * upper.c[0], upper.m * upper.c[2]]
    arm = np.concatenate([axial, _ten(machine.lower), k])
    return np.concatenate([np.tile(arm, 6), _ten(machine.end_effector)])


def _ten(body: Body) -> Array:
    return np.concatenate([[body.m], body.m * body.c, _six(body.J)])

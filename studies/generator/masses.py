"""Masses and stiffness of a machine: all that enters its torque linearly."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tests.oracles.calculus import Array
from tests.oracles.machine import Machine


@dataclass(frozen=True)
class Linear:
    """All that enters the torque linearly: first moments mc [kg m], J [kg m2] about the origin.

    upper (2,) = mc_x, mc_z; axial (6,) = J about the motor axes with rotor; lower and platform
    (10,) = m, mc (3), J xx, yy, zz, xy, xz, yz; k_u, k_s (2,) [N m/rad]. Trailing axes may
    follow that go with those of the samples: machines side by side.
    """

    upper: Array
    axial: Array
    lower: Array
    platform: Array
    k_u: Array
    k_s: Array


def linear(machine: Machine) -> Linear:
    """The values of a machine; its J_rotor may be (6,)."""
    upper = machine.upper
    return Linear(
        upper.m * upper.c[[0, 2]],
        upper.J[1, 1] + np.broadcast_to(np.asarray(machine.J_rotor, float), 6),
        ten(machine.lower.m, machine.lower.c, machine.lower.J),
        ten(machine.end_effector.m, machine.end_effector.c, machine.end_effector.J),
        machine.k_u,
        machine.k_s,
    )


def ten(m: float, c: Array, J: Array) -> Array:
    """m, mc, J as ten numbers."""
    return np.concatenate([[m], m * c, J[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]])


def zero() -> Linear:
    """No mass, no stiffness."""
    return Linear(*(np.zeros(n) for n in (2, 6, 10, 10, 2, 2)))


def units() -> list[Linear]:
    """One per column of a regression: a single one, all else zero."""
    directions = []
    for name, values in vars(zero()).items():
        for row in np.eye(len(values)):
            directions.append(replace(zero(), **{name: row}))
    return directions

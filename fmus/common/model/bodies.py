"""Parameters of the mechanism: inertias about the frames' origins and joint stiffness.

`Mechanism` holds them for every arm apart, as numbers or as casadi.SX. The plant uses it
in full (112 values); the 30 estimated ones are embedded by `parameters.base_mechanism`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from flexhex.fmus.common.inertia import inertia_rows
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.machine.sections import Body

INERTIA_NAMES = ("m", "mc_x", "mc_y", "mc_z", "J_xx", "J_yy", "J_zz", "J_xy", "J_xz", "J_yz")
INERTIA_UNITS = ("kg", "kg m", "kg m", "kg m") + ("kg m2",) * 6
UPPER_NAMES, UPPER_UNITS = ("J", "mc_x", "mc_z"), ("kg m2", "kg m", "kg m")
STIFFNESS_NAMES = ("k_u2", "k_u3", "k_s1", "k_s2")
_POSITIVE = {"m", "J", "J_xx", "J_yy", "J_zz", *STIFFNESS_NAMES}


@dataclass(frozen=True)
class Mechanism:
    """Parameters of all arms; without a platform all but `upper` are empty.

    upper[i] (3,): J about the motor axis, mc_x, mc_z; lower[i], end_effector (10,): m, mc, J
    about the frame's origin; stiffness[i] (4,): k_u2, k_u3, k_s1, k_s2."""

    upper: list[Any]
    lower: list[Any]
    end_effector: Any
    stiffness: list[Any]

    def vector(self) -> Any:
        """All values in one column, arm by arm, end-effector last (17 n_arms + 10)."""
        if not self.lower:
            return ca.vertcat(*self.upper)
        arms = zip(self.upper, self.lower, self.stiffness, strict=True)
        parts = [part for arm in arms for part in arm]
        return ca.vertcat(*parts, self.end_effector)

    @staticmethod
    def split(v: Any, n: int) -> Mechanism:
        """The inverse of `vector`."""
        if v.numel() == len(UPPER_NAMES) * n:
            return Mechanism([v[3 * i : 3 * (i + 1)] for i in range(n)], [], None, [])
        per = len(mechanism_names(1)) - len(INERTIA_NAMES)
        arms = [v[per * i : per * (i + 1)] for i in range(n)]
        return Mechanism(
            [a[0:3] for a in arms], [a[3:13] for a in arms], v[per * n :], [a[13:17] for a in arms]
        )


def positive(name: str) -> bool:
    """Whether no machine has a value of the mechanism below zero: a mass, a moment of inertia about
    an axis, a stiffness. First moments and products of inertia have either sign."""
    return name.rpartition(".")[2] in _POSITIVE


def mechanism_names(n: int, platform: bool = True) -> tuple[str, ...]:
    """Names of `Mechanism.vector`, such as `lower[2].mc_x`."""
    return tuple(name for name, _ in _entries(n, platform))


def mechanism_units(n: int, platform: bool = True) -> tuple[str, ...]:
    """Units of `Mechanism.vector`."""
    return tuple(unit for _, unit in _entries(n, platform))


def _entries(n: int, platform: bool) -> list[tuple[str, str]]:
    entries = []
    for i in range(1, n + 1):
        upper = zip(UPPER_NAMES, UPPER_UNITS, strict=True)
        entries += [(f"upper[{i}].{name}", unit) for name, unit in upper]
        if not platform:
            continue
        lower = zip(INERTIA_NAMES, INERTIA_UNITS, strict=True)
        entries += [(f"lower[{i}].{name}", unit) for name, unit in lower]
        entries += [(f"flexure[{i}].{name}", "N m/rad") for name in STIFFNESS_NAMES]
    if platform:
        body = zip(INERTIA_NAMES, INERTIA_UNITS, strict=True)
        entries += [(f"end_effector.{name}", unit) for name, unit in body]
    return entries


def inertia(body: Body) -> NDArray[np.float64]:
    """(10,): m, m c, J about the frame's origin (Huygens-Steiner)."""
    Ic = np.array(inertia_rows(body.Ic))
    ten: NDArray[np.float64] = _about_origin(body.m, np.array(body.c), Ic)
    return ten


def point_mass(m: Any, r: Any) -> Any:
    """(10,) of a point mass m [kg] at r (3,) [m]; numbers or SX."""
    x, y, z = r[0], r[1], r[2]
    J = (y * y + z * z, x * x + z * z, x * x + y * y, -x * y, -x * z, -y * z)
    return ca.vertcat(m, m * x, m * y, m * z, *(m * entry for entry in J))


def nominal_mechanism(machine: Machine) -> Mechanism:
    """The mechanism that the machine file describes, as numbers."""
    n, arm = machine.n_arms, machine.bodies.upper
    body = inertia(arm)
    upper = np.array([body[5] + arm.J_rotor, body[1], body[3]])
    if not machine.has_platform:
        return Mechanism([upper] * n, [], None, [])
    platform = machine.platform
    stiffness = np.array([*platform.flexures.k_u, *platform.flexures.k_s])
    lower, end_effector = inertia(platform.lower), inertia(platform.end_effector)
    return Mechanism([upper] * n, [lower] * n, end_effector, [stiffness] * n)


def _about_origin(m: float, c: NDArray[np.float64], Ic: NDArray[np.float64]) -> Any:
    J = Ic + m * (c @ c * np.eye(3) - np.outer(c, c))
    return np.array([m, *(m * c), J[0, 0], J[1, 1], J[2, 2], J[0, 1], J[0, 2], J[1, 2]])

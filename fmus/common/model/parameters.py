"""The estimated parameters p: 22 of each actuator and 30 of the mechanism (162).

[SH, III-E] keeps 162 after "excluding parameters that have become redundant" without
naming them. docs/decisions/0002-parameters.md gives the reasons: the mass and mc_x of the
lower arm are redundant (two point masses at its ends act alike), the rest is shared
between the arms as far as the arms are made alike, the actuators are each their own.
Gains of a machine's effects come behind the 162.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.model.bodies import (
    INERTIA_NAMES,
    INERTIA_UNITS,
    STIFFNESS_NAMES,
    Mechanism,
    nominal_mechanism,
    point_mass,
)
from flexhex.fmus.common.model.effect_bank import Bank

Array = NDArray[np.float64]
ACTUATOR = "actuator"
"""`actuator[2].o`: parameters by the section of the machine file that they belong to."""
_TERM = re.compile(rf"{ACTUATOR}\[\d+\]\.(\w)(?:\[\d+\])?")
_LOWER = (2, 3, 4, 5, 6, 7, 8, 9)
"""Lower-arm entries that are estimated: all but m and mc_x."""


@dataclass(frozen=True)
class Parameter:
    """One estimated parameter: name, unit, the body it belongs to, and a scale [unit] below
    which its size counts as zero (floor of the normalisation)."""

    name: str
    unit: str
    body: str
    floor: float


def actuator_parameters(machine: Machine) -> list[Parameter]:
    """o, k, d, c, then a_n, b_n by harmonic, for each actuator.  [SH, Eq. (22)]"""
    listed = []
    for i in range(1, machine.n_arms + 1):
        body, own = f"actuator {i}", f"{ACTUATOR}[{i}]"
        listed += [
            Parameter(f"{own}.o", "N m", body, 0.1),
            Parameter(f"{own}.k", "N m/rad", body, 0.1),
            Parameter(f"{own}.d", "N m s/rad", body, 0.005),
            Parameter(f"{own}.c", "N m", body, 0.02),
        ]
        for n in range(1, machine.actuator.n_harmonics + 1):
            listed += [Parameter(f"{own}.{ab}[{n}]", "N m", body, 0.01) for ab in "ab"]
    return listed


def term(name: str) -> str:
    """`o` of `actuator[2].o`, `a` of `actuator[1].a[3]`; empty for what is no actuator's."""
    match = _TERM.fullmatch(name)
    return match[1] if match else ""


def mechanism_parameters(machine: Machine) -> list[Parameter]:
    """The 30 of the mechanism: J of each upper arm, what the arms share, E; 8 without platform."""
    floors = {"kg": 0.1, "kg m": 0.005, "kg m2": 5e-4, "N m/rad": 0.05}
    listed = [
        Parameter(f"upper.J[{i}]", "kg m2", f"upper arm {i}", 5e-4)
        for i in range(1, machine.n_arms + 1)
    ]
    listed += [Parameter(f"upper.{n}", "kg m", "upper arms", 0.005) for n in ("mc_x", "mc_z")]
    if not machine.has_platform:
        return listed
    for k in _LOWER:
        name, unit = INERTIA_NAMES[k], INERTIA_UNITS[k]
        listed.append(Parameter(f"lower.{name}", unit, "lower arms", floors[unit]))
    for name, unit in zip(INERTIA_NAMES, INERTIA_UNITS, strict=True):
        listed.append(Parameter(f"end_effector.{name}", unit, "end-effector", floors[unit]))
    for name in STIFFNESS_NAMES:
        listed.append(Parameter(f"flexure.{name}", "N m/rad", "flexures", floors["N m/rad"]))
    return listed


def effect_parameters(machine: Machine) -> list[Parameter]:
    """Gains of the machine's effects, as far as the feedforward compensates them."""
    bank = Bank.compensated(machine)
    return [
        Parameter(name, gain.unit, "effects", gain.typical)
        for name, (_, gain) in zip(bank.names, bank.gains, strict=True)
    ]


def parameters(machine: Machine) -> tuple[Parameter, ...]:
    """All estimated parameters in the order of p: actuators, mechanism, effects."""
    return (
        *actuator_parameters(machine),
        *mechanism_parameters(machine),
        *effect_parameters(machine),
    )


def base_mechanism(machine: Machine, p: Any) -> Mechanism:
    """Mechanism whose full parameters carry the 30 estimated ones, p (30,).

    Lower arms have m = mc_x = 0: their ends' masses are carried by their neighbours.
    """
    n = machine.n_arms
    upper = [ca.vertcat(p[i], p[n], p[n + 1]) for i in range(n)]
    if not machine.has_platform:
        return Mechanism(upper, [], None, [])
    lower = ca.vertcat(0, 0, p[n + 2 : n + 10])
    end_effector, stiffness = p[n + 10 : n + 20], p[n + 20 : n + 24]
    return Mechanism(upper, [lower] * n, end_effector, [stiffness] * n)


def base_parameters(machine: Machine) -> Array:
    """The nominal p (162,) of a machine file: its actuators and its regrouped mechanism.

    Behind them come the gains of its effects.
    """
    a = machine.actuator
    parts: list[float] = []
    for i in range(machine.n_arms):
        parts += [a.o[i], a.k[i], a.d[i], a.c[i]]
        parts += [value for pair in zip(a.a[i], a.b[i], strict=True) for value in pair]
    effects = Bank.compensated(machine).values
    return np.concatenate([parts, regrouped(machine, nominal_mechanism(machine)), effects])


def regrouped(machine: Machine, full: Mechanism) -> Array:
    """The 30 mechanism parameters that move exactly like `full`, whose arms are alike.

    A lower arm with mass m and first moment mc_x acts like point masses mc_x/l at P_i and
    m - mc_x/l at Q_i beside what remains of its inertia; they are added to E and to the
    upper arm. Where arms differ, shared entries are means and the result is approximate.
    """
    n = machine.n_arms
    if not machine.has_platform:
        arms = np.array([np.array(upper, dtype=float).ravel() for upper in full.upper])
        return np.concatenate([arms[:, 0], arms[:, 1:].mean(axis=0)])
    L, l, r_EP = machine.geometry.L, machine.platform.l, machine.platform.r_EP  # noqa: E741
    end_effector = np.array(full.end_effector, dtype=float).ravel()
    uppers, rests = [], []
    for i in range(n):
        upper = np.array(full.upper[i], dtype=float).ravel().copy()
        lower = np.array(full.lower[i], dtype=float).ravel().copy()
        at_P = lower[1] / l
        at_Q = lower[0] - at_P
        end_effector = end_effector + np.array(point_mass(at_P, r_EP[i])).ravel()
        upper += [at_Q * L**2, at_Q * L, 0.0]
        lower[[5, 6]] -= at_P * l**2
        uppers.append(upper)
        rests.append(lower[list(_LOWER)])
    shared = np.mean(uppers, axis=0)[1:]
    stiffness = np.mean([np.array(k, dtype=float).ravel() for k in full.stiffness], axis=0)
    J = [upper[0] for upper in uppers]
    return np.concatenate([J, shared, np.mean(rests, axis=0), end_effector, stiffness])

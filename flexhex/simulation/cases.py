"""The cases of [SH, V-A] as variants of one loop: which plant, which parts act, which p.

A case is nothing but other start values of the same FMUs, baked in as their defaults,
since some importers ignore parameter sets.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexhex.fmus.common.errors import MachineError
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.model.parameters import base_parameters
from flexhex.fmus.estimator.interface import first_variance, normalisation
from flexhex.tracking import SETTLE as SETTLE

Array = NDArray[np.float64]
FIT_SEED, RUN_SEED = 11, 1
WARM = 1200.0
"""The data for the fit come from a cold machine, the cases run on a warm one [s]."""


@dataclass(frozen=True)
class Case:
    """One run: name (also its folder), title, plant FMU, start values by component instance."""

    name: str
    title: str
    plant: str
    duration: float
    starts: Mapping[str, Mapping[str, float | Array]] = field(default_factory=dict)


def _case(
    name: str,
    title: str,
    machine: Machine,
    *,
    plant: str = "machine",
    ff_gain: float = 1.0,
    adapt: bool = False,
    p: Array | None = None,
    std: Array | None = None,
    duration: float,
    seed: int = RUN_SEED,
    age: float = WARM,
    basis: float = 1.0,
) -> Case:
    p0 = base_parameters(machine) if p is None else p
    starts: dict[str, Mapping[str, float | Array]] = {
        "reference": {"seed": float(seed), "t_start": SETTLE, "duration": duration},
        "feedback": {"ff_gain": ff_gain},
        "W": {"basis": basis},
        "K": {
            "p0": p0,
            "scale": normalisation(machine, p0),
            "P0": first_variance(machine, p0, std),
            "adapt": float(adapt),
        },
    }
    if plant == "machine":
        starts["plant"] = {"age": age}
    return Case(name, title, plant, SETTLE + duration, starts)


def check_settle(machine: Machine) -> None:
    """MachineError when the hold before the first move is no whole number of base steps."""
    steps = SETTLE / machine.timing.base
    if abs(steps - round(steps)) > 1e-6:
        raise MachineError(
            f"timing.base: the {SETTLE:g} s held before the first move are {steps:.9g} base steps,"
            " must be a whole number"
        )


def whole_moves(machine: Machine, seconds: float) -> float:
    """The shortest trajectory of at least `seconds` [s] that holds whole periods."""
    period = machine.reference.period
    return math.ceil(seconds / period - 1e-9) * period


def fit_case(machine: Machine, duration: float) -> Case:
    """The run whose log p-hat is fitted to: another trajectory, feedback and nominal model."""
    return _case("fit", "data for the fit", machine, duration=duration, seed=FIT_SEED, age=0.0)


def table_cases(
    machine: Machine, p: Array, duration: float, std: Array | None = None
) -> tuple[Case, ...]:
    """The rows of Table I, on machine.fmu with the fitted p; std: its deviations, from which the
    adaptation starts."""
    adaptive: dict[str, Any] = {"p": p, "std": std, "adapt": True, "duration": duration}
    return (
        _case("feedback", "feedback only", machine, ff_gain=0.0, p=p, duration=duration),
        _case("fixed", "fixed feedforward", machine, p=p, duration=duration),
        _case("adaptive", "adaptive feedforward", machine, **adaptive),
    )


def extra_cases(
    machine: Machine, p: Array, duration: float, std: Array | None = None
) -> tuple[Case, ...]:
    """What the table does not show: the exact plant, and the paper's form of W.

    exact-*: plant.fmu, which is the model itself, with exact parameters.
    """
    exact: dict[str, Any] = {"plant": "plant", "duration": duration}
    paper: dict[str, Any] = {"p": p, "std": std, "adapt": True, "basis": 0.0}
    title = "adaptive, the paper's form of W"
    return (
        _case("paper-form", title, machine, duration=duration, **paper),
        _case("exact-fixed", "exact plant, fixed", machine, **exact),
        _case("exact-adaptive", "exact plant, adaptive", machine, adapt=True, **exact),
        _case("exact-paper-form", f"exact plant, {title}", machine, adapt=True, basis=0.0, **exact),
    )

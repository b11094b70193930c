"""A fit that plant.fmu can be given: no mass, moment of inertia or stiffness is below zero."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnose.replay import plant_values
from flexhex.diagnosis.estimation.identify import Fit
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.model.bodies import mechanism_names, positive

Array = NDArray[np.float64]
LEAST = 1e-9
"""What is held in the place of zero [kg, kg m2, N m/rad]: no rounding takes it below."""


def below(machine: Machine, p: Array) -> tuple[str, ...]:
    """Values of plant.fmu that are below zero for a fit p (n_p,), though no machine has them so."""
    names = mechanism_names(machine.n_arms, machine.has_platform)
    values = plant_values(machine, p)["mechanism"]
    pairs = zip(names, values, strict=True)
    return tuple(name for name, value in pairs if positive(name) and value < 0)


def physical(machine: Machine, fitted: Fit) -> Fit:
    """The best fit with what no machine has below zero at zero, the rest as this leaves it.

    The values that noise took below zero are given, and the others follow by the covariance of the
    fit. ValueError where the fit has none.
    """
    held = set[str]()
    p = fitted.p
    while more := set(below(machine, p)) - held:
        if fitted.covariance is None:
            raise ValueError("a fit without covariance")
        held |= more
        rows, missing = _rows(machine, fitted.p, held)
        C = fitted.covariance
        p = fitted.p + C @ rows.T @ np.linalg.solve(rows @ C @ rows.T, missing)
    return replace(fitted, p=p) if held else fitted


def _rows(machine: Machine, p: Array, held: set[str]) -> tuple[Array, Array]:
    """The values that are held as rows of p (k, n_p), and what they are short by (k,)."""
    names = mechanism_names(machine.n_arms, machine.has_platform)
    chosen = [k for k, name in enumerate(names) if name in held]

    def full(p: Array) -> Array:
        return plant_values(machine, p)["mechanism"][chosen]

    values = full(p)
    rows = np.column_stack([full(p + unit) - values for unit in np.eye(len(p))])
    # of zeros and ones but for rounding; arms share values: one row for all of them
    rows, first = np.unique(np.round(rows), axis=0, return_index=True)
    return rows, LEAST - values[first]

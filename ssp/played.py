"""Samples for inputs of a system: a measured torque for the plant, an angle for a controller."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flexhex.fmus.common.errors import UsageError
from flexhex.ssp.fmu import FmuVariable
from flexhex.ssp.read import Package
from flexhex.ssp.signals import arrays
from flexhex.ssp.wiring import unknown

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Played:
    """rows (base steps, k), one behind the other: what the k inputs of `ends`, as (component,
    scalar), take."""

    ends: tuple[tuple[str, str], ...]
    rows: Array


def played(package: Package, inputs: Mapping[str, Array], n_steps: int) -> Played:
    """Samples by name, `{"plant.tau": (n_steps, 6)}`, as the executor plays them.

    UsageError for a name that is no input, too few rows, a wrong number of columns, no numbers.
    """
    ends: list[tuple[str, str]] = []
    columns = [np.zeros((n_steps, 0))]
    for text, samples in inputs.items():
        component, _, name = text.partition(".")
        instances = {i.name: i for i in package.instances}
        if component not in instances:
            raise UsageError(f"input {text!r}: {unknown('component', component, instances)}")
        known = arrays(v for v in instances[component].fmu.of("input") if v.type != "String")
        if name not in known:
            raise UsageError(f"input {text!r}: in {component} {unknown('input', name, known)}")
        scalars = known[name].scalars
        columns.append(_rows(text, samples, n_steps, scalars))
        ends += [(component, v.name) for v in scalars]
    return Played(tuple(ends), np.ascontiguousarray(np.hstack(columns)))


def _rows(text: str, samples: Array, n_steps: int, scalars: Sequence[FmuVariable]) -> Array:
    width = len(scalars)
    rows = np.asarray(samples, dtype=float)
    rows = rows[:, None] if rows.ndim == 1 else rows
    if rows.ndim != 2 or rows.shape[1] != width or len(rows) < n_steps:
        raise UsageError(
            f"input {text!r}: samples of shape {np.shape(samples)}, needed are {n_steps} rows, one"
            f" for each base step, of {width}"
        )
    bad = ~np.isfinite(rows[:n_steps]).all(axis=1)
    if bad.any():
        raise UsageError(f"input {text!r}: row {int(bad.argmax())} is not finite")
    for v, column in zip(scalars, rows[:n_steps].T, strict=True):
        wrong = [] if v.type == "Real" else [x for x in column.tolist() if v.objection(x)]
        if wrong:
            raise UsageError(f"input {text!r}: {v.name} = {v.objection(wrong[0])}")
    return rows[:n_steps]

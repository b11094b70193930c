"""Runs a .ssp with the C executor: each FMU at its own sample time, results by rate."""

from __future__ import annotations

import hashlib
import math
import tempfile
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import cast

import numpy as np
from numpy.typing import NDArray

from flexhex.fmus.common.archive import read_bytes
from flexhex.fmus.common.errors import InterfaceError, UsageError
from flexhex.ssp import library
from flexhex.ssp.parameters import Value, number_for
from flexhex.ssp.played import played
from flexhex.ssp.read import Package, read_ssp
from flexhex.ssp.results import Result
from flexhex.ssp.schedule import Progress, Schedule
from flexhex.ssp.signals import LoggedVariable, arrays, select
from flexhex.ssp.wiring import unknown

Parameters = Mapping[str, Value | Sequence[Value]]
Inputs = Mapping[str, NDArray[np.float64]]


def run(
    system: str | Path | Package,
    duration: float,
    *,
    signals: Sequence[str] | None = None,
    progress: Progress | None = None,
    parameters: Parameters | None = None,
    inputs: Inputs | None = None,
    timing: bool = True,
    cache: Path | None = None,
) -> Result:
    """Run a .ssp, or one that was read, for `duration` [s].

    signals: what to log, see `flexhex.ssp.signals.select`; None logs all outputs but the large
    arrays. progress(done, total) [s] is called about ten times a second; Ctrl-C works
    there. parameters: `{"reference.seed": 3, "reference.amplitude": [..6], "reference.kind":
    "chirp"}`, over what the .ssp says; of an enumeration the item's name, of a Boolean True or
    "true" are taken as well. inputs: `{"plant.tau": samples}`, a row of samples for each base step,
    taken in the place of what the input is connected to. timing: measure the time in each FMU.
    cache: where the executor is compiled, default the user's cache.

    Raises UsageError (duration, signals, parameters, inputs), InterfaceError (the .ssp) and
    RunError (which FMU refused what, when, and its message).
    """
    package = system if isinstance(system, Package) else read_ssp(system)
    n_steps = _base_steps(duration, package.base)
    overrides = _overrides(package, parameters or {})
    logged, samples = select(package, signals), played(package, inputs or {}, n_steps)
    c = library.load(cache)
    with tempfile.TemporaryDirectory(prefix="flexhex-") as folder:
        schedule = Schedule(package, overrides, logged, samples, Path(folder))
        begin = time.perf_counter()
        schedule.execute(c, n_steps, progress, timing)
        wall = time.perf_counter() - begin
    meta: dict[str, str | int | float] = {"ssp": package.path.name, "base_step": package.base}
    if not isinstance(system, Package):
        meta["sha256 ssp"] = hashlib.sha256(read_bytes(system)).hexdigest()
    meta |= {f"sha256 {Path(i.source).name}": i.fmu.sha256 for i in package.instances}
    for name, values in overrides.items():
        meta |= {f"parameter {name}.{key}": value for key, value in values.items()}
    return Result(schedule.groups(), schedule.times, n_steps * package.base, wall, meta)


def _base_steps(duration: float, base: float) -> int:
    steps = duration / base
    if not (math.isfinite(steps) and steps > 0):
        raise UsageError(f"duration {duration:g} s: must be a finite time above 0")
    if round(steps) < 1 or abs(steps - round(steps)) > 1e-6:
        near = max(round(steps), 1) * base
        raise UsageError(
            f"duration {duration:g} s is {steps:.6g} base steps of {base:g} s,"
            f" must be a whole number of at least one, as in {near:.9g}"
        )
    return round(steps)


def _overrides(package: Package, parameters: Parameters) -> dict[str, dict[str, float]]:
    """Scalar values by component and FMI name."""
    overrides: dict[str, dict[str, float]] = {i.name: {} for i in package.instances}
    for text, value in parameters.items():
        component, _, name = text.partition(".")
        if component not in overrides:
            raise UsageError(f"parameter {text!r}: {unknown('component', component, overrides)}")
        fmu = package.instance(component).fmu
        variables = fmu.of("parameter")
        known = arrays(variables) | {v.name: LoggedVariable(v.name, (v,)) for v in variables}
        if name not in known:
            raise UsageError(f"parameter {text!r}: in {component} {unknown('name', name, known)}")
        scalars = known[name].scalars
        listed = value if np.ndim(value) else [value] * len(scalars)
        values = list(cast(Sequence[Value], listed))
        if len(values) != len(scalars):
            raise UsageError(f"parameter {text!r}: {len(values)} values for {len(scalars)}")
        for v, x in zip(scalars, values, strict=True):
            try:
                overrides[component][v.name] = number_for(f"{component}.{v.name}", x, v, fmu)
            except InterfaceError as error:
                raise UsageError(f"parameter {error}") from None
    return overrides

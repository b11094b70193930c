"""The adaptive loop that every importer runs, and what the own executor says of it.

The default experiment rests for two seconds. Here the reference moves and the estimator adapts
almost at once; both are start values of the FMUs themselves, since FMPy and the toolbox ignore
parameter sets.
"""

from __future__ import annotations

import importlib
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import ModuleType

import numpy as np
import numpy.typing as npt
import pytest

from flexhex.simulation.cases import Case
from flexhex.ssp.executor import Parameters, run
from flexhex.ssp.read import Package, period, read_ssp

Array = npt.NDArray[np.float64]
Rows = Mapping[str, Array]
"""Scalar name `plant.theta[1]` -> what is seen at base steps 1, 2, ..."""
BASE = 0.00025
LIBCOSIM = "pip install libcosimpy"
SECONDS = 2.0
N_STEPS = 8000
CASE = Case(
    "importers",
    "moves and adapts at once",
    "plant",
    SECONDS,
    {"reference": {"t_start": 0.06}, "K": {"t_start": 0.03}},
)


def scalars(package: Package) -> dict[str, list[str]]:
    """Output connectors of the .ssp by component: those that are connected or plotted."""
    listed = {(w.source, w.output) for w in package.wires}
    return {
        i.name: [v.name for v in i.fmu.of("output") if (i.name, v.name) in listed]
        for i in package.instances
    }


def own_rows(path: Path, parameters: Parameters | None = None) -> Rows:
    """Rows of the multi-rate executor; a slow component holds its values between its ticks."""
    package = read_ssp(path)
    result = run(path, SECONDS, signals=[i.name for i in package.instances], parameters=parameters)
    seen = np.arange(1, N_STEPS + 1)
    rows = {}
    for component, names in scalars(package).items():
        repeats = seen // period(package.instance(component), package.base)
        for name in names:
            rows[f"{component}.{name}"] = result[f"{component}.{name}"][repeats]
    return rows


def assert_same_bits(actual: Rows, expected: Rows, what: str) -> None:
    """Every row of every signal is equal to the last bit, and the loop did something."""
    assert actual.keys() == expected.keys(), what
    assert np.ptp(expected["plant.theta[1]"]) > 0.01, "the loop rests: nothing was shown"
    assert len(expected["plant.theta[1]"]) >= 100, "hardly anything was compared"
    estimates = [name for name in expected if name.startswith("K.p.")]
    if estimates:
        adapted = max(np.ptp(expected[name]) for name in estimates)
        assert adapted > 0.01, "nothing adapts: nothing was shown"
    for name, values in expected.items():
        theirs = np.ascontiguousarray(actual[name])
        assert theirs.shape == values.shape, f"{what}: {name} has {len(theirs)} rows"
        if theirs.tobytes() != np.ascontiguousarray(values).tobytes():
            first = int(np.flatnonzero(theirs != values)[0])
            off = float(np.max(np.abs(theirs - values)))
            raise AssertionError(
                f"{what}: {name} differs from row {first} on, at most by {off:.3g}"
            )


def wanted(module: str, how: str) -> ModuleType:
    """An importer's package; the test is skipped, saying how to install it, when it is missing."""
    try:
        return importlib.import_module(module)
    except (ImportError, OSError) as error:
        pytest.skip(f"{module} is not usable ({error}): {how}")


def tool(variable: str, default: str, how: str) -> str:
    """Path of a program: from the environment, or where `how` puts it; else the test is skipped."""
    path = Path(os.environ.get(variable) or default).expanduser()
    if not path.exists():
        pytest.skip(f"{path} is missing: {how}")
    return str(path.absolute())


def libcosim_rows(source: str, folder: Path, package: Package) -> Rows:
    """Run libcosim; source: `from_ssp_file` or `from_osp_config_file`, both name a folder."""
    wanted("libcosimpy", LIBCOSIM)
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
    from libcosimpy.CosimObserver import CosimObserver

    log_output_level(CosimLogLevel.ERROR)
    execution = getattr(CosimExecution, source)(str(folder))
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer=observer)
    index = {slave.name.decode(): slave.index for slave in execution.slave_infos()}
    outputs = scalars(package)
    references = {
        name: [package.instance(name).fmu.variables[s].reference for s in listed]
        for name, listed in outputs.items()
    }
    rows: dict[str, list[list[float]]] = {name: [] for name in outputs}
    for _ in range(N_STEPS):
        assert execution.step()
        for name, listed in references.items():
            rows[name].append(list(observer.last_real_values(index[name], listed)))
    assert execution.status().current_time == N_STEPS * 250_000, "not the base step [ns]"
    columns: dict[str, Array] = {}
    for name, listed in outputs.items():
        columns |= rows_of(rows[name], [f"{name}.{s}" for s in listed])
    return columns


def rows_of(rows: Sequence[Sequence[float]] | Array, names: Sequence[str]) -> Rows:
    """Rows by name from one list of values for each recorded step."""
    columns = np.asarray(rows, dtype=np.float64)
    return {name: columns[:, k] for k, name in enumerate(names)}

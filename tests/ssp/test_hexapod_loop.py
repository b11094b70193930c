"""The real adaptive loop: the multi-rate executor equals FMPy's base-step master bit for bit."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fmpy.ssp.simulation import simulate_ssp
from fmpy.ssp.ssd import Parameter, ParameterSet, read_ssd

from flexhex.ssp.executor import run
from flexhex.ssp.read import period, read_ssp
from flexhex.ssp.results import Result

BASE = 0.00025
# The default experiment rests for two seconds; here it moves and adapts almost at once.
PARAMETERS = {"reference.t_start": 0.06, "K.t_start": 0.03}


def fmpy_rows(path: Path, n_steps: int) -> Any:
    """FMPy's record; row k holds what is seen at base step k + 1 (see test_executor.py)."""
    parameters = ParameterSet(
        parameters=[Parameter(name=name, value=value) for name, value in PARAMETERS.items()]
    )
    stop = (n_steps - 0.5) * BASE
    return simulate_ssp(str(path), stop_time=stop, step_size=BASE, parameter_set=parameters)


def assert_equal_bits(path: Path, result: Result, rows: Any, n_steps: int) -> None:
    """Every output connector of the .ssp, at every tick of its own component."""
    package = read_ssp(path)
    periods = {i.name: period(i, package.base) for i in package.instances}
    compared = 0
    for component in read_ssd(str(path)).system.elements:
        steps = periods[component.name]
        for connector in (c for c in component.connectors if c.kind == "output"):
            ours = result[f"{component.name}.{connector.name}"][1:]
            theirs = rows[f"{component.name}.{connector.name}"][steps - 1 :: steps]
            assert len(theirs) == n_steps // steps
            theirs = theirs.astype(np.float64)  # an enumeration is a whole number, a Boolean 0 or 1
            assert ours.tobytes() == theirs.tobytes(), f"{component.name}.{connector.name}"
            compared += 1
    assert compared > 500, "hardly anything was compared"


@pytest.mark.parametrize(
    "n_steps", [480, pytest.param(4200, marks=pytest.mark.slow)], ids=["0.12s", "1.05s"]
)
def test_executor_equals_fmpy_on_the_adaptive_loop(
    hexapod_ssp: Path, cache: Path, n_steps: int
) -> None:
    components = [i.name for i in read_ssp(hexapod_ssp).instances]
    result = run(
        hexapod_ssp, n_steps * BASE, signals=components, parameters=PARAMETERS, cache=cache
    )
    assert_equal_bits(hexapod_ssp, result, fmpy_rows(hexapod_ssp, n_steps), n_steps)
    assert np.ptp(result["reference.r"]) > 1e-4, "the reference rests: nothing was shown"
    assert np.any(np.ptp(result["K.p"], axis=0) > 0), "nothing adapts: nothing was shown"


def test_loop_runs_without_faults(hexapod_ssp: Path, cache: Path) -> None:
    result = run(hexapod_ssp, 1.05, parameters=PARAMETERS, cache=cache)
    for name in ("reference", "N_F", "F", "feedback", "plant", "W", "N_E", "K"):
        assert not result[f"{name}.fault"].any(), name
    assert np.max(np.abs(result["feedback.e"])) < 0.01

"""Faults of a run: named once, for console, report and JSON."""

from __future__ import annotations

import numpy as np

from flexhex.simulation.faults import Fault, faults
from flexhex.ssp.fmu import item_of, listed
from flexhex.ssp.results import Group, Result


def test_fault_is_named_with_its_time_and_share() -> None:
    fault = np.zeros(200)
    fault[150:] = 3.0
    fault[160:] = 2.0
    signals = {"feedback.fault": fault, "plant.fault": np.zeros(200), "plant.theta": fault}
    result = faults("fixed", Result({"a": Group(2, 0.25, signals)}, duration=100.0))
    assert result == [Fault("fixed", "feedback.fault", 3.0, 75.0, 0.25)]
    assert str(result[0]) == "fixed: feedback.fault = 3 from 75 s on, 25.0% of the samples"


def test_fault_is_called_what_the_fmu_calls_it() -> None:
    signals = {"plant.fault": np.array([0.0, 2.0])}
    items = {"none": 0, "refused": 1, "end_stop": 2, "other": 12}
    texts = {"plant.fault": f"what is wrong: {listed(items)}"}
    result = faults("run", Result({"a": Group(1, 0.5, signals, {}, texts)}, duration=1.0))
    assert str(result[0]) == "run: plant.fault = 2 (end_stop) from 0.5 s on, 50.0% of the samples"
    assert [item_of(texts["plant.fault"], k) for k in (0, 1, 12, 3)] == [
        "none",
        "refused",
        "other",
        "",
    ]

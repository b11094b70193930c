"""Faults of a run: named once, for console, report and JSON."""

from __future__ import annotations

import numpy as np

from flexhex.simulation.faults import Fault, faults
from flexhex.ssp.results import Group, Result


def test_fault_is_named_with_its_time_and_share() -> None:
    fault = np.zeros(200)
    fault[150:] = 3.0
    fault[160:] = 2.0
    signals = {"feedback.fault": fault, "plant.fault": np.zeros(200), "plant.theta": fault}
    found = faults("fixed", Result({"a": Group(2, 0.25, signals)}, duration=100.0))
    assert found == [Fault("fixed", "feedback.fault", 3.0, 75.0, 0.25)]
    assert str(found[0]) == "fixed: feedback.fault = 3 from 75 s on, 25.0% of the samples"

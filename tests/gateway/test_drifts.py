"""How little the torques say about an encoder that drifts: the table of docs/gateway-figures.md."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.gateway.bench import Bench
from tests.gateway.fault_table import DRIFTS, Off, Table
from tests.gateway.test_falls import HOLD, RAD, fault
from tests.gateway.weight import TS, Fallen, free

SPEED = 0.05
"""Of the drift [rad/s]."""
CASES = ((1, SPEED), (1, -SPEED), (3, SPEED), (3, -SPEED))
"""Positions, and which way: the reference stands still, and the model is fixed."""
STANDS = ("\n[bus]", '\n[system.parameters]\n"reference.kind" = "hold"\n"K.t_start" = 1e6\n\n[bus]')
MEAN = 200
"""Cycles of a mean torque."""


def drifted(fallen: Fallen, axis: int, off: float) -> np.ndarray:
    """Changes of the torques of all axes where the true angle is off by so much [N m]."""
    before = fallen.tau[HOLD - 4 * MEAN : HOLD].mean(axis=0)
    moved = np.abs(fallen.theta[HOLD:, axis] - fallen.theta[HOLD, axis]) > off
    n = HOLD + int(np.flatnonzero(moved)[0])
    change: np.ndarray = fallen.tau[n - MEAN : n].mean(axis=0) - before
    return change


@pytest.mark.slow
def test_drifting_encoder_changes_torques_by_less_than_a_fixed_model_misses(
    hexapod_ssp: Path, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    table = Table(bool(request.config.getoption("--update")), DRIFTS)
    runs = []
    for position, speed in CASES:
        options = fault("encoder_drift", HOLD, position=position, size=round(speed * RAD * TS))
        fallen = free(Bench(hexapod_ssp, tmp_path), options, changes=(STANDS,), seconds=10.0)
        assert not [e for e in fallen.ran.events if e["event"] == "trip"], "no rule sees it"
        runs.append((fallen, position))
    for off in (0.05, 0.1, 0.2, 0.3, 0.4):
        changes = [float(np.abs(drifted(fallen, k, off)).max()) for fallen, k in runs]
        table.add(Off(off, min(changes), max(changes)))
    table.write()

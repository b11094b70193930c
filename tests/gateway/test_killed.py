"""A gateway that is killed while it enables or disables the drives: their watchdogs act."""

from __future__ import annotations

import signal
from pathlib import Path

import numpy as np
import pytest

from tests.gateway.alone import kills, paused
from tests.gateway.bench import Bench
from tests.gateway.test_ctrl_c import FIRST, at_frame
from tests.gateway.weight import Fallen, free

ON = {"switched on", "operation enabled", "quick stop active", "fault reaction active"}
"""States in which a drive has voltage at its motor, or is to have it."""
ENABLING = range(FIRST, FIRST + 45, 3)
"""Frames of any kind: from the first process data to operation enabled."""


def without_power(fallen: Fallen) -> set[str]:
    """No drive has power; the machine rests. Returns the states that the drives had before."""
    ran = fallen.ran
    assert ran.code == -signal.SIGKILL
    assert not ON & set(fallen.stopped["drives"]), fallen.stopped
    assert fallen.stopped["fastest"] < 0.1
    silence = ran.happened("silence")[0]["cycle"]
    before = {e["position"]: e["to"] for e in ran.happened("drive") if e["cycle"] <= silence}
    return set(before.values())


@pytest.mark.sample(3)
@pytest.mark.parametrize("frame", ENABLING)
def test_killed_while_drives_are_enabled(frame: int, hexapod_ssp: Path, tmp_path: Path) -> None:
    bench = Bench(hexapod_ssp, tmp_path)
    fallen = free(bench, at_frame(frame), paused=kills(bench), seconds=100.0)
    states = without_power(fallen)
    if states & ON:
        # in OP with process data: every drive had a watchdog to act
        assert {e["position"] for e in fallen.ran.happened("watchdog")} == set(range(6))


@pytest.mark.parametrize("later", [-1, 0, 1, 2])
def test_killed_while_drives_are_disabled(later: int, hexapod_ssp: Path, tmp_path: Path) -> None:
    """In cycles about that in which they lose their power, at the end of a good run."""
    bench = Bench(hexapod_ssp, tmp_path)
    good = free(bench, seconds=0.05)
    assert good.ran.code == 0, good.ran.words
    left = {e["cycle"] for e in good.ran.happened("drive") if e["from"] == "operation enabled"}
    (begun,) = {e["cycle"] for e in good.ran.happened("enabled")}
    (end,) = left
    fallen = free(bench, paused(end - begun + later), paused=kills(bench), seconds=0.05)
    states = without_power(fallen)
    assert ("operation enabled" in states) == (later < 0)
    assert np.abs(fallen.tau[-100:]).max() == 0.0

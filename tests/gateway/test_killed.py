"""A gateway that is killed while it enables or disables the drives: their watchdogs act."""

from __future__ import annotations

import signal
from pathlib import Path

import pytest

from tests.gateway.alone import paused
from tests.gateway.bench import Bench, Process
from tests.gateway.test_ctrl_c import FIRST, at_frame
from tests.gateway.test_landing import AT
from tests.gateway.weight import Fallen, free

ON = {"switched on", "operation enabled", "quick stop active", "fault reaction active"}
"""States in which a drive has voltage at its motor, or is to have it."""
ENABLING = range(FIRST, FIRST + 45, 3)
"""Frames of any kind: from the first process data to operation enabled."""


def dies(gateway: Process, drives: Process) -> None:
    """Ends the gateway without an orderly shutdown; nobody sends a frame any more."""
    gateway.kill()
    gateway.wait()
    drives.send_signal(signal.SIGCONT)


def without_power(fallen: Fallen) -> set[str]:
    """No drive has power; the machine rests. Returns the states that the drives had before."""
    ran = fallen.ran
    assert ran.code == -signal.SIGKILL
    assert not ON & set(fallen.stopped["drives"]), fallen.stopped
    before = {}
    for event in ran.drives:
        if event["event"] == "watchdog":
            break
        if event["event"] == "drive":
            before[event["position"]] = event["to"]
    return set(before.values())


@pytest.mark.sample(3)
@pytest.mark.parametrize("frame", ENABLING)
def test_killed_while_drives_are_enabled(frame: int, hexapod_ssp: Path, tmp_path: Path) -> None:
    bench = Bench(hexapod_ssp, tmp_path)
    fallen = free(bench, at_frame(frame), paused=dies, seconds=100.0)
    states = without_power(fallen)
    assert fallen.stopped["fastest"] < 0.1, "it rests where it rested"
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
    at = end - begun + later
    fallen = free(bench, paused(at), paused=dies, seconds=0.05)
    states = without_power(fallen)
    assert ("operation enabled" in states) == (later <= 0)
    assert fallen.speed[at:].max() < 0.2, "it has landed"


def test_next_start_removes_what_a_killed_gateway_unpacked(
    hexapod_ssp: Path, tmp_path: Path
) -> None:
    """And nothing of others: what is held by a process that lives is tested beside the code."""
    place = tmp_path / "temporary"
    place.mkdir()
    (place / "flexhex-other").mkdir()
    bench, within = Bench(hexapod_ssp, tmp_path), ("env", f"TMPDIR={place}")
    bench.run(options=paused(AT), paused=dies, seconds=100.0, wrapper=within)
    (left,) = place.glob("flexhex-fmus-*")
    assert list(left.rglob("*.so")), "what it unpacked"
    bench.run(command=("check",), wrapper=within)
    assert [path.name for path in place.iterdir()] == ["flexhex-other"]

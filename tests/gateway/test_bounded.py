"""What is late or never comes is waited for no longer than its bound."""

from __future__ import annotations

import os
import re
import signal
import time
from pathlib import Path

import pytest

from tests.gateway.archives import Spoil, spoiled
from tests.gateway.bench import Bench, columns
from tests.gateway.fault_table import Row, Table
from tests.gateway.test_faults import ANY_STEP, time_ms
from tests.gateway.test_readback import PATIENT
from tests.gateway.test_refusals import when_running

hanging = pytest.mark.sample(1, of="loops that hang")

PAUSED_S = 0.4
"""The gateway stands still for so long while it holds, before it lands."""


def test_late_cycle_in_a_landing_is_reported_and_the_landing_goes_on(
    hexapod_ssp: Path, tmp_path: Path
) -> None:
    def stall(pid: int) -> None:
        os.kill(pid, signal.SIGINT)
        for kind, seconds in ((signal.SIGSTOP, 0.4), (signal.SIGCONT, PAUSED_S)):
            time.sleep(seconds)
            os.kill(pid, kind)

    changes = (
        ("watchdog_ms = 5 ", "watchdog_ms = 1000 #"),
        ("overrun_us = 2000", "overrun_us = 200000"),
        ("lost_frame_limit = 8", "lost_frame_limit = 900"),
        ("hold_ms = 300", "hold_ms = 1500"),
        ("jump_rad = 0.001", "jump_rad = 0.05"),
    )
    ran = Bench(hexapod_ssp, tmp_path).run(
        command=("run", "--enable"), seconds=60.0, changes=changes, during=when_running(stall)
    )
    summary = ran.one("summary")
    assert ran.code == 1, ran.words
    assert re.search(r"cycle started \d+ us late, allowed 200000 us", summary["landing_trip"])
    assert summary["cycles_to_zero"] >= 1.5 / 0.00025, "it was held and landed all the same"
    assert summary["not_disabled"] == []
    assert "stopped on request, during the landing cycle started" in ran.words


RESTS = 400
"""A cycle before the reference moves: where cycles are lost, nothing is far from where it was."""


@hanging
def test_loop_that_hangs_in_an_fmu_ends_and_keeps_what_it_recorded(
    hexapod_ssp: Path, tmp_path: Path, table: Table
) -> None:
    """An FMU that never returns: the drives' watchdog takes the torque, the gateway names it."""
    bad = spoiled(hexapod_ssp, Spoil("F", RESTS // 2, "sleep", value=1e6), tmp_path / "bad.ssp")
    changes = (*PATIENT, ANY_STEP, ("watchdog_ms = 1000", "watchdog_ms = 900"),
               ("lost_frame_limit = 8", "lost_frame_limit = 900"),
               # replies that come late on a busy computer are no jumps of an encoder
               ("jump_rad = 0.001", "jump_rad = 0.05"))  # fmt: skip
    begin = time.monotonic()
    ran = Bench(bad, tmp_path).run(
        plant=hexapod_ssp, changes=changes, command=("run", "--enable"), seconds=1000.0
    )
    assert time.monotonic() - begin < 60, "it waits for ever"
    assert ran.code == 1, ran.words
    hung = ran.one("hung")
    assert hung["component"] == "F"
    # all six are read back, which is told, and the run has failed all the same
    states = {e["position"]: e["state"] for e in ran.events if e["event"] == "device"}
    assert len(states) == 6
    assert not set(states.values()) & {"operation enabled", "switched on"}
    assert ran.one("off")["devices"] == 6
    assert "no drive is energised" in ran.words
    assert {e["position"] for e in ran.happened("watchdog")} == set(range(6))
    rows = ran.table["cycle"]
    assert rows[-1] == RESTS, "every cycle before it"
    (trip,) = tmp_path.glob("run-trip*.csv")
    assert re.search(r"# trip: hung: F hangs", trip.read_text())
    assert columns(trip)["cycle"][-1] == RESTS
    table.add(Row("FMU never returns", "hung", "watchdog of the drives", None, None))


@hanging
def test_estimator_that_hangs_is_held_for_its_limit_and_then_landed(
    hexapod_ssp: Path, tmp_path: Path, table: Table
) -> None:
    """K never returns: its last p is kept for two ticks, and the end does not wait for it."""
    bad = spoiled(hexapod_ssp, Spoil("K", 75, "sleep", value=1e6), tmp_path / "bad.ssp")
    changes = (("late_limit = 10", "late_limit = 2"),)
    begin = time.monotonic()
    ran = Bench(bad, tmp_path).run(plant=hexapod_ssp, changes=changes)
    assert time.monotonic() - begin < 60, "it waits for ever"
    trip = ran.one("trip")
    assert (trip["reason"], trip["reaction"]) == ("late_thread", "land")
    # fed at 75 * 120, its result is due at 76 * 120, and so are two more
    assert trip["cycle"] == 78 * 120 - 1
    assert "K: fed at base step 9000, not finished 3 of its periods later" in trip["detail"]
    assert ran.one("summary")["not_disabled"] == []
    assert not list(tmp_path.glob("*estimate*"))
    first = 76 * 120 - 1
    row = Row(
        "estimator never returns",
        trip["reason"],
        "land",
        trip["cycle"] - first,
        time_ms(ran, first),
    )
    table.add(row)

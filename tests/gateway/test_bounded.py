"""What is late or never comes is waited for no longer than its bound."""

from __future__ import annotations

import json
import re
import signal
from pathlib import Path

import pytest

from tests.gateway.archives import Spoil, spoiled
from tests.gateway.bench import Bench, Process, columns, never_enabled
from tests.gateway.fault_table import Row, Table
from tests.gateway.test_falls import LATE
from tests.gateway.test_faults import time_ms
from tests.gateway.test_stalls import CYCLES, PATIENT, stall
from tests.gateway.weight import TS, free

hanging = pytest.mark.sample(1, of="loops that hang")


def test_late_cycle_in_a_landing_is_reported_and_the_landing_goes_on(
    hexapod_ssp: Path, tmp_path: Path
) -> None:
    fallen = free(Bench(hexapod_ssp, tmp_path), stall(LATE), changes=(PATIENT,), seconds=2.5)
    ran, late_us = fallen.ran, round(CYCLES * TS * 1e6)
    summary = ran.one("summary")
    assert ran.code == 1, ran.words
    assert f"cycle started {late_us} us late, allowed 2000 us" in summary["landing_trip"]
    off = [e["cycle"] for e in ran.happened("torque_zero")]
    assert min(off) > LATE + 1000, "it is carried on"
    assert summary["not_disabled"] == []
    assert "done, during the landing cycle started" in ran.words
    fallen.ends_at_rest(LATE)


NEUTRAL = ("--to", "0,0,0,0,0,0")
RESTS = 400
"""A cycle before the reference moves."""
SILENT = "silence_s = 3\n"
"""The plant goes on after this time without frames: before the gateway notices that it hangs."""


@hanging
def test_loop_that_hangs_in_an_fmu_ends_and_keeps_what_it_recorded(
    hexapod_ssp: Path, tmp_path: Path, table: Table
) -> None:
    """An FMU that never returns: the drives' watchdog takes the torque, the gateway names it."""
    bad = spoiled(hexapod_ssp, Spoil("F", RESTS // 2, "sleep", value=1e6), tmp_path / "bad.ssp")
    ran = Bench(bad, tmp_path).run(plant=hexapod_ssp, options=SILENT, seconds=1000.0)
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


def test_fmu_that_hangs_before_power_is_ended_by_ctrl_c(hexapod_ssp: Path, tmp_path: Path) -> None:
    """The model that judges the motion never returns; no frame has been sent."""
    bad = spoiled(hexapod_ssp, Spoil("F-model-ahead", 0, "hang"), tmp_path / "bad.ssp")

    def interrupt(gateway: Process) -> None:
        assert gateway.stderr
        assert any("hangs" in line for line in gateway.stderr)
        gateway.send_signal(signal.SIGINT)

    ran = Bench(bad, tmp_path).run(plant=hexapod_ssp, during=interrupt)
    assert ran.code == -signal.SIGINT
    never_enabled(ran)


RUN, MOVE = ("run", "--enable", "--lockstep"), ("move", "--enable", "--lockstep", *NEUTRAL)
CHECK = ("check",)


@pytest.mark.parametrize(
    ("instance", "step", "call", "command", "named"),
    [
        ("F-model-ahead", 300, "hang", RUN, "F-model-ahead"),
        ("reference-ahead", 300, "hang", RUN, "reference-ahead"),
        ("N_F-gain-ways", 4, "hang", MOVE, "N_F-gain-ways"),
        ("K", -1, "hang", CHECK, "K"),
        ("F", -1, "hang", CHECK, "one of reference, N_F, F, feedback, W, N_E"),
        ("N_F-gain", 0, "instantiate", RUN, "N_F-gain"),
        ("F-model-ahead", 200, "put", RUN, "F-model-ahead"),
        ("reference-ahead", 200, "get", RUN, "reference-ahead"),
        ("F-model-ahead", 0, "terminate", RUN, "one of N_F-model-ahead, F-model-ahead"),
        ("K", 0, "free", CHECK, "K"),
    ],
)
def test_fmu_that_hangs_before_power_is_named_and_ends_the_command(
    instance: str,
    step: int,
    call: str,
    command: tuple[str, ...],
    named: str,
    hexapod_ssp: Path,
    tmp_path: Path,
) -> None:
    """The model of a brake, the reference ahead, the pose of a way, two initialisations, and every
    other call."""
    bad = spoiled(hexapod_ssp, Spoil(instance, step, call), tmp_path / "bad.ssp")
    ran = Bench(bad, tmp_path).run(plant=hexapod_ssp, command=command)
    assert ran.code == 3, ran.words
    message = str(ran.one("refused")["message"])
    assert message.startswith(f"{named} hangs: no answer for 3 s; no drive has power yet"), message
    never_enabled(ran)
    assert not ran.recording.exists()


def test_long_run_says_how_far_it_is_judged(hexapod_ssp: Path, tmp_path: Path) -> None:
    """Twelve days are judged for a minute before power; Ctrl-C ends it."""

    def interrupt(gateway: Process) -> None:
        assert gateway.stdout
        told = next(json.loads(line) for line in gateway.stdout if '"judging"' in line)
        assert told["of_s"] == 1e6
        assert 0 < told["time_s"] < 1e6
        gateway.send_signal(signal.SIGINT)

    ran = Bench(hexapod_ssp, tmp_path).run(seconds=1e6, during=interrupt)
    assert ran.code == -signal.SIGINT
    assert "judging    the motion of 1000000 s, before power" in ran.words
    never_enabled(ran)


def test_fmu_that_fails_before_power_is_refused(hexapod_ssp: Path, tmp_path: Path) -> None:
    """The model that judges the motion; a landing would want it, too."""
    bad = spoiled(hexapod_ssp, Spoil("F-model-ahead", 40, "error"), tmp_path / "bad.ssp")
    ran = Bench(bad, tmp_path).run(plant=hexapod_ssp)
    assert ran.code == 3, ran.words
    assert "F-model-ahead: fmi2DoStep" in str(ran.one("refused")["message"])
    never_enabled(ran)


@hanging
def test_estimator_that_hangs_is_held_for_its_limit_and_then_landed(
    hexapod_ssp: Path, tmp_path: Path, table: Table
) -> None:
    """K never returns: its last p is kept for two ticks, and the end does not wait for it."""
    bad = spoiled(hexapod_ssp, Spoil("K", 75, "sleep", value=1e6), tmp_path / "bad.ssp")
    changes = (("late_limit = 10", "late_limit = 2"),)
    ran = Bench(bad, tmp_path).run(plant=hexapod_ssp, changes=changes)
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

"""Faults of the program, of the estimate and of the bring-up, of a machine with weight."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.gateway.archives import Spoil, spoiled
from tests.gateway.bench import Bench, Ran, drive, never_enabled
from tests.gateway.fault_table import Table
from tests.gateway.test_faults import ANY_STEP
from tests.gateway.test_landing import AT, STEP, at
from tests.gateway.weight import free

several = pytest.mark.sample(4, of="falls of runs")

WRONG = Spoil("K", 75, "set", "p.actuator[1].o", 21.6, 100_000)
"""The estimator shows a torque offset of 21.6 N m, from cycle 9000 of the controller on."""
WRONG_FROM_START = "--set", 'system.parameters={"K.p0.actuator[1].o"=-21.6}'
UNGUARDED = ("range = 5.0", "range = 1000.0")


def test_good_run_falls_nowhere(hexapod_ssp: Path, tmp_path: Path, falls: Table) -> None:
    fallen = free(Bench(hexapod_ssp, tmp_path))
    assert fallen.ran.code == 0, fallen.ran.words
    fallen.ends_at_rest(0)
    assert fallen.ran.one("summary")["frozen"] == []
    falls.add(fallen.fall("no fault", 0))


@several
def test_warning_of_a_drive_is_reported_and_stops_nothing(
    hexapod_ssp: Path, tmp_path: Path, falls: Table
) -> None:
    warned = at('kind = "warning"\nposition = 2\ncount = 100', AT)
    fallen = free(Bench(hexapod_ssp, tmp_path), warned)
    assert fallen.ran.code == 0, fallen.ran.words
    expected = [[3, "warning (bit 7 of the statusword)", 100]]
    assert fallen.ran.one("summary")["remarks"] == expected
    assert "axis 3: warning (bit 7 of the statusword) in 100 cycles" in fallen.ran.words
    fallen.ends_at_rest(AT)
    falls.add(fallen.fall("drive shows a warning", AT))


@several
def test_wrong_estimate_is_frozen_and_the_run_goes_on(
    hexapod_ssp: Path, tmp_path: Path, falls: Table
) -> None:
    bad = spoiled(hexapod_ssp, WRONG, tmp_path / "bad.ssp")
    fallen = free(Bench(bad, tmp_path), plant=hexapod_ssp, changes=(
        ("signals = []", 'signals = ["K.p.actuator[1].o"]'),))  # fmt: skip
    ran = fallen.ran
    assert ran.code == 0, ran.words
    (frozen,) = ran.one("summary")["frozen"]
    assert frozen.startswith("K.p.actuator[1].o = 21.600000 at base step 9120, allowed -")
    assert "frozen" in ran.words
    assert "estimate   not saved" in ran.words
    # the last good p stays, and it is not the first one
    running = ran.table["phase"] == 1
    p = ran.table["K.p.actuator[1].o"][running]
    assert np.all(p[9000:] == p[9000])
    assert 0 < abs(p[9000] - p[0]) < 1
    fallen.ends_at_rest(AT)
    falls.add(fallen.fall("estimate jumps by 21.6 N m", AT))


@several
def test_wrong_estimate_that_nobody_bounds_is_stopped_before_it_is_sent(
    hexapod_ssp: Path, tmp_path: Path, falls: Table
) -> None:
    """Without its bounds, and from the first cycle, where no bounds help."""
    bad = spoiled(hexapod_ssp, WRONG, tmp_path / "bad.ssp")
    one = free(Bench(bad, tmp_path), plant=hexapod_ssp, changes=(UNGUARDED,))
    command = ("run", "--enable", "--lockstep", *WRONG_FROM_START)
    two = free(Bench(hexapod_ssp, tmp_path), command=command)
    for name, fallen, step in (("estimate jumps by 21.6 N m, not bounded", one, STEP),
                               ("estimate wrong by 21.6 N m from the start", two, 0)):  # fmt: skip
        trip = fallen.ran.one("trip")
        assert (trip["reason"], trip["reaction"]) == ("torque_step", "land")
        assert np.abs(fallen.tau).max() < 3, "the wrong torque is never sent"
        fallen.ends_at_rest(0)
        falls.add(fallen.fall(name, 0, step))
    # one period of the estimator and one of the feedforward after it
    assert one.ran.one("trip")["cycle"] in range(9120, 9124)


def test_fault_of_an_fmu_at_full_torque_is_landed(
    hexapod_ssp: Path, tmp_path: Path, falls: Table
) -> None:
    """16 N m are sent when `feedback` reports a fault: fading them drove the axis to 12.5 rad/s."""
    parameters = "system.parameters={'K.p0.actuator[1].o'=-21.6,'feedback.e_max'=0.005}"
    parameters = parameters.replace("'", '"')
    fallen = free(
        Bench(hexapod_ssp, tmp_path),
        command=("run", "--enable", "--lockstep", "--set", parameters),
        changes=(ANY_STEP,),
    )
    trip = fallen.ran.one("trip")
    assert (trip["reason"], trip["reaction"]) == ("fmu_fault", "land")
    assert np.abs(fallen.tau).max() > 10, "the estimate is wrong"
    since = int(np.flatnonzero(np.abs(fallen.tau).max(axis=1) > 10)[-1]) + 1
    row = replace(fallen.fall("FMU reports a fault while 16 N m are sent", since), cycles=None)
    falls.add(row)
    fallen.ends_at_rest(since + 200)


@several
def test_estimator_that_hangs_is_landed_with_its_weight(
    hexapod_ssp: Path, tmp_path: Path, falls: Table
) -> None:
    bad = spoiled(hexapod_ssp, Spoil("K", 60, "sleep", value=1e6), tmp_path / "bad.ssp")
    fallen = free(
        Bench(bad, tmp_path), plant=hexapod_ssp, changes=(("late_limit = 10", "late_limit = 2"),)
    )
    trip = fallen.ran.one("trip")
    assert (trip["reason"], trip["reaction"], trip["cycle"]) == (
        "late_thread",
        "land",
        63 * 120 - 1,
    )
    fallen.ends_at_rest(0)
    falls.add(fallen.fall("estimator never returns", 0, 60 * 120))


@several
def test_fmu_that_never_returns_leaves_it_to_the_watchdogs(
    hexapod_ssp: Path, tmp_path: Path, falls: Table
) -> None:
    """The gateway names it, and disables and reads back the drives afterwards."""
    bad = spoiled(hexapod_ssp, Spoil("F", STEP // 2, "sleep", value=1e6), tmp_path / "bad.ssp")
    # before the gateway notices that it hangs, and not where a busy computer waits
    fallen = free(Bench(bad, tmp_path), "silence_s = 3\n", plant=hexapod_ssp)
    assert fallen.ran.code == 1
    assert fallen.ran.one("hung")["component"] == "F"
    assert fallen.ran.one("off")["devices"] == 6
    since = int(fallen.ran.happened("silence")[0]["cycle"])
    off = {e["cycle"] - since for e in fallen.ran.happened("torque_zero")}
    assert len(off) == 1
    fallen.ends_at_rest(since)
    row = fallen.row("FMU never returns", "watchdog of the drives", "zero", since, cycles=off.pop())
    falls.add(row)


def lost_frames(first: int, count: int) -> str:
    """Replies lost before the drives are enabled."""
    kind = 'kind = "frame_lost"\nacting = "after"\ncounting = "frames"'
    return f"[[fault]]\n{kind}\ncycle = {first}\ncount = {count}\n"


@several
def test_pose_is_judged_although_the_first_replies_are_lost(
    hexapod_ssp: Path, tmp_path: Path, falls: Table
) -> None:
    """One lost reply skipped the check, and all drives were energised 0.3 rad off."""
    changes = (
        (
            "# rest_rad = [-0.34, -0.35, -0.34, -0.37, -0.35, -0.37]",
            "rest_rad = [0, 0, 0, 0, 0, 0]",
        ),
    )
    op = free(Bench(hexapod_ssp, tmp_path), seconds=0.01).ran
    first = next(e["frame"] for e in op.happened("state") if e["to"] == "OP")
    for begin in range(first, first + 24, 3):
        fallen = free(Bench(hexapod_ssp, tmp_path), lost_frames(begin, 4), changes=changes)
        assert fallen.ran.code == 1, begin
        assert "landing.rest_rad = 0 rad" in fallen.ran.one("refused")["message"]
        never_enabled(fallen.ran)
    falls.add(fallen.refused("another pose, and the first replies are lost"))


@several
def test_replies_lost_on_the_way_to_op_stop_nothing(
    hexapod_ssp: Path, tmp_path: Path, falls: Table
) -> None:
    for first in (1, 2, 3):
        fallen = free(Bench(hexapod_ssp, tmp_path), lost_frames(first, 1), seconds=0.01)
        assert fallen.ran.code == 0, fallen.ran.words
        fallen.ends_at_rest(0)
    falls.add(fallen.fall("a reply is lost on the way to OP", 0))


def enabled_for(ran: Ran) -> int:
    """Frames from the first enabled drive to the last that is disabled."""
    on = [e["frame"] for e in ran.happened("drive") if e["to"] == "operation enabled"]
    off = [e["frame"] for e in ran.happened("drive") if e["from"] == "operation enabled"]
    assert len(on) == len(off) == 5
    assert max(on) == min(on), "by one frame"
    return max(off) - min(on)


@several
def test_drives_are_enabled_together_or_not_for_long(
    hexapod_ssp: Path, tmp_path: Path, falls: Table
) -> None:
    """Five drives stayed enabled for 5 s while the sixth was waited for."""
    options = drive(5, "never_enabled = true")
    fallen = free(Bench(hexapod_ssp, tmp_path), options)
    ran = fallen.ran
    assert ran.code == 1
    assert "axis 6: switched on, but others have been enabled" in ran.one("refused")["message"]
    # landing.enable_ms = 20 and the frames that disable
    assert enabled_for(ran) in range(80, 90)
    assert ran.one("summary")["not_disabled"] == []
    assert fallen.stopped["fastest"] < 1.0
    falls.add(fallen.refused("a drive is not enabled with the others", "zero"))
    # the others wait for one that changes its state more slowly
    for more, frames in (("", 1), (drive(2, "slow = 7"), 7)):
        good = free(Bench(hexapod_ssp, tmp_path), more, seconds=0.01).ran
        on = [e["frame"] for e in good.happened("drive") if e["to"] == "operation enabled"]
        assert len(on) == 6
        assert max(on) - min(on) < frames


def test_encoder_scale_that_is_not_compared_needs_a_rest_pose(
    hexapod_ssp: Path, tmp_path: Path, falls: Table
) -> None:
    """All encoders 4096 times too coarse: refused by the pose, or the pose must be given."""
    unchecked = ("# unchecked = [0x608F]", "unchecked = [0x608F]")
    rest = ("# rest_rad", "rest_rad")
    bench = Bench(hexapod_ssp, tmp_path)
    options = "drives.counts_per_rev = 1048576.0\n"
    ran = bench.run(options=options, changes=(unchecked,))
    assert ran.code == 3
    assert "landing.rest_rad" in ran.one("refused")["message"]
    fallen = free(bench, options, changes=(unchecked, rest))
    ran = fallen.ran
    assert ran.code == 1
    assert "landing.rest_rad = -0.34 rad" in ran.one("refused")["message"]
    never_enabled(ran)
    falls.add(fallen.refused("encoders too coarse, and their scale is not compared"))


@several
def test_replies_that_stay_incomplete_while_enabling_take_the_power(
    hexapod_ssp: Path, tmp_path: Path, falls: Table
) -> None:
    """Drives stayed enabled for 5 s, as incomplete replies were not judged yet."""
    good = free(Bench(hexapod_ssp, tmp_path), seconds=0.01).ran
    first = min(e["frame"] for e in good.happened("drive") if e["to"] == "operation enabled")
    short = lost_frames(first, 0).replace("frame_lost", "wkc_short").replace("acting", "# acting")
    fallen = free(Bench(hexapod_ssp, tmp_path), f"{short}position = 2\n")
    assert fallen.ran.code == 1
    assert "being enabled: working counter 15, expected 18" in fallen.ran.one("refused")["message"]
    left = [e["frame"] for e in fallen.ran.happened("drive") if e["from"] == "operation enabled"]
    # the drive that does not hear is left to its watchdog of 20 cycles
    assert [frame - first for frame in sorted(left)] == [4] * 5 + [20]
    falls.add(fallen.refused("working counter short from the frame on that enables", "zero"))

"""Faults of a machine with weight: which stop follows, how fast it falls, and what is said."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from tests.gateway.archives import Spoil, spoiled
from tests.gateway.bench import Bench, never_enabled
from tests.gateway.fault_table import Table
from tests.gateway.test_faults import ANY_STEP
from tests.gateway.weight import free

AT = 21_000
"""Cycle of every fault since enabling: the machine has lifted off and moves at 0.7 rad/s."""
STEP = 9000
"""Step of an FMU that goes wrong: 2.25 s after the controller began."""


@dataclass(frozen=True)
class Case:
    """A fault of drives, encoders or cable; the rule, the stop, and axes that are not confirmed."""

    name: str
    fault: str
    reason: str
    stop: str
    axis: int | None = None
    unknown: tuple[int, ...] = ()


ALL = (1, 2, 3, 4, 5, 6)
CASES = (
    Case("drive shows another mode", 'kind = "mode_change"\nposition = 2', "mode", "zero", 3),
    Case("drive fault", 'kind = "drive_fault"\nposition = 2', "drive_fault", "damp", 3),
    Case("drive drops to SAFE-OP", 'kind = "safe_op"\nposition = 4', "al_state", "zero", 5),
    Case("encoder jumps 1.5 mrad", 'kind = "encoder_jump"\nposition = 1', "jump", "damp", 2),
    Case("encoder frozen", 'kind = "encoder_frozen"\nposition = 3', "frozen_encoder", "damp", 4),
    Case(
        "working counter short, 3 cycles",
        'kind = "wkc_short"\ncount = 3',
        "working_counter",
        "zero",
    ),
    Case(
        "cable cut before the first drive",
        'kind = "cable_cut"\nposition = 0',
        "lost_frames",
        "zero",
        None,
        ALL,
    ),
    Case(
        "cable cut between drives 3 and 4",
        'kind = "cable_cut"\nposition = 3',
        "working_counter",
        "zero",
        None,
        ALL[3:],
    ),
)


def at(fault: str, cycle: int = AT) -> str:
    """Options of the emulator for a fault."""
    return f"[[fault]]\ncycle = {cycle}\n{fault}\n"


@pytest.mark.sample(4)
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_fault_of_drives_and_encoders_lands_the_machine(
    case: Case, hexapod_ssp: Path, tmp_path: Path, falls: Table
) -> None:
    fallen = free(Bench(hexapod_ssp, tmp_path), at(case.fault))
    trip = fallen.ran.one("trip")
    assert fallen.ran.code == 1
    assert (trip["reason"], trip["axis"], trip["reaction"]) == (case.reason, case.axis, case.stop)
    fallen.ends_at_rest(AT)
    assert fallen.disabled() == [0, 1, 2, 3, 4, 5]
    # what could not be asked is not said to be disabled
    summary = fallen.ran.one("summary")
    assert summary["not_disabled"] == list(case.unknown)
    assert ("not confirmed as disabled" in fallen.ran.words) == bool(case.unknown)
    falls.add(fallen.fall(case.name, AT))


BROKEN = {
    "not_finite": Spoil("feedback", STEP, "set", "tau[2]", math.nan),
    "fmu_error": Spoil("F", STEP // 2, "error"),
    "fmu_fault": Spoil("N_E", STEP // 2, "set", "fault", 4.0),
    "following_error": Spoil("reference", STEP, "set", "r[2]", 0.3, 400),
    "torque": Spoil("feedback", STEP, "set", "tau[2]", 30.0),
    "fmu_overrun": Spoil("feedback", STEP, "sleep", value=1.5),
}


@pytest.mark.sample(3)
@pytest.mark.parametrize("reason", BROKEN)
def test_fault_of_the_controller_lands_the_machine_without_it(
    reason: str, hexapod_ssp: Path, tmp_path: Path, falls: Table
) -> None:
    bad = spoiled(hexapod_ssp, BROKEN[reason], tmp_path / "bad.ssp")
    changes = (ANY_STEP,) if reason == "following_error" else ()
    fallen = free(Bench(bad, tmp_path), plant=hexapod_ssp, changes=changes)
    trip = fallen.ran.one("trip")
    assert (fallen.ran.code, trip["reason"], trip["reaction"]) == (1, reason, "land")
    fallen.ends_at_rest(AT)
    assert fallen.ran.one("summary")["not_disabled"] == []
    assert fallen.ran.one("summary")["landing_trip"] is None
    # nobody pulls it down: power is taken where the machine rests anyway
    assert np.ptp(fallen.theta[-20_000:], axis=0).max() < 0.05
    falls.add(fallen.fall(f"{BROKEN[reason].instance}: {reason}", AT, STEP))


@pytest.mark.parametrize(
    ("name", "options", "reason"),
    [
        ("lost", 'kind = "frame_lost"\ncount = 0\nprobability = 0.6', "lost_frames"),
        ("short", 'kind = "wkc_short"\ncount = 0\nprobability = 0.5', "working_counter"),
    ],
)
def test_replies_that_fail_too_often_stop_the_machine(
    name: str, options: str, reason: str, hexapod_ssp: Path, tmp_path: Path
) -> None:
    changes = (("lost_frame_limit = 8", "lost_frame_limit = 40"),
               ("working_counter_limit = 3", "working_counter_limit = 40"),
               # longer than those limits, or they would be refused
               ("watchdog_ms = 5", "watchdog_ms = 20"))  # fmt: skip
    fallen = free(Bench(hexapod_ssp, tmp_path), at(options, 8000), changes=changes)
    assert fallen.ran.one("trip")["reason"] == reason, name
    fallen.ends_at_rest(8000)


def test_wrong_estimate_at_full_torque_is_landed_and_not_faded(
    hexapod_ssp: Path, tmp_path: Path
) -> None:
    """16 N m on an axis when the run is over: fading them drove it to 12.5 rad/s (D1)."""
    more = ("--set", 'system.parameters={"K.p0.actuator[1].o"=-21.6}')
    fallen = free(
        Bench(hexapod_ssp, tmp_path),
        seconds=0.008,
        command=("run", "--enable", "--lockstep", *more),
        # or it would be stopped before it is sent
        changes=(ANY_STEP,),
    )
    assert np.abs(fallen.tau).max() > 10, "the estimate is wrong"
    assert np.abs(fallen.theta).max() <= 0.5236
    end = int(np.flatnonzero(np.abs(fallen.tau).max(axis=1) > 10)[-1]) + 400
    fallen.ends_at_rest(end)
    assert fallen.ran.one("summary")["not_disabled"] == []


def test_drive_that_keeps_its_power_is_named(hexapod_ssp: Path, tmp_path: Path) -> None:
    options = at('kind = "control_ignored"\nposition = 1')
    ran = free(Bench(hexapod_ssp, tmp_path), options).ran
    assert ran.code == 1
    assert ran.one("summary")["not_disabled"] == [2]
    assert "done, drives not confirmed as disabled: axes [2]" in ran.words


def test_machine_that_moves_is_not_enabled(hexapod_ssp: Path, tmp_path: Path, falls: Table) -> None:
    """A fifth of a second after it was let go it falls."""
    fallen = free(Bench(hexapod_ssp, tmp_path), resting=0.2)
    assert fallen.ran.code == 1
    assert "wait until the machine rests" in fallen.ran.one("refused")["message"]
    never_enabled(fallen.ran)
    falls.add(fallen.refused("the machine still falls"))

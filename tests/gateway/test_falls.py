"""Every further fault of the list in faults.md, of a machine with weight: rule, stop, fall, drives."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.gateway.bench import Bench, drive
from tests.gateway.fault_table import Fall, Table
from tests.gateway.test_landing import ALL, AT, at
from tests.gateway.weight import free

HOLD = 14_000
"""Cycle since enabling: the machine has lifted off, the reference stands still."""
RAD = 2**32 / (2 * 3.141592653589793)
"""Counts of a radian."""


@dataclass(frozen=True)
class Case:
    """A fault; the rule and the stop (none: it goes on), axes that are not confirmed."""

    name: str
    options: str
    rule: str = "none"
    stop: str = "–"
    axis: int | None = None
    unknown: tuple[int, ...] = ()
    since: int = AT
    changes: tuple[tuple[str, str], ...] = ()
    seconds: float = 2.5
    falls: bool = False
    """No reaction can hold it: only what is said is checked, and the row shows the rest."""


def drift(speed: float) -> str:
    """An encoder that drifts [rad/s] from the hold on."""
    return at(f'kind = "encoder_drift"\nposition = 1\nsize = {round(speed * RAD * 0.00025)}', HOLD)


def lost(burst: int, every: int) -> str:
    """Replies that are lost in bursts, for ever."""
    return at(
        f'kind = "frame_lost"\nacting = "after"\ncount = 0\nburst = {burst}\nevery = {every}', HOLD
    )


SHORT = 'kind = "wkc_short"\nposition = 2\ncount = 0'
PUSH = 'kind = "push"\nposition = 3\n'
CASES = (
    Case("drive drops to SAFE-OP without an error flag", at('kind = "safe_op"\nposition = 4\ncode = 0'),
         "al_state", "zero", 5),
    Case("emergency stop (STO) of all drives", at('kind = "sto"'), "drive_state", "zero", 1),
    Case("encoder jumps 0.8 mrad", at('kind = "encoder_jump"\nposition = 1\nsize = 546000')),
    Case("working counter short, for ever", at(SHORT, HOLD), "working_counter", "zero", since=HOLD),
    Case("working counter short, 2 cycles", at('kind = "wkc_short"\ncount = 2')),
    Case("working counter short, 2 of every 3 cycles", at(f"{SHORT}\nburst = 2\nevery = 3", HOLD),
         "working_counter", "zero", since=HOLD),
    Case("working counter short, 1 of every 5 cycles", at(f"{SHORT}\nburst = 1\nevery = 5", HOLD),
         since=HOLD),
    Case("replies lost, 7 of every 8", lost(7, 8), "lost_frames", "zero", since=HOLD),
    Case("replies lost, 1 of every 5", lost(1, 5), since=HOLD),
    Case("replies lost, 30 %", at('kind = "frame_lost"\nacting = "after"\ncount = 0\nprobability = 0.3',
         HOLD), "lost_frames", "zero", since=HOLD),
    Case("replies late by a cycle, 10 %", at('kind = "frame_delayed"\ncount = 0\nprobability = 0.1', 1),
         since=0),
    Case("encoder frozen while the reference stands still", at('kind = "encoder_frozen"\nposition = 3',
         HOLD), "frozen_encoder", "damp", 4, since=HOLD),
    Case("encoder drifts by 0.05 rad/s", drift(0.05), since=HOLD),
    Case("encoder drifts by -0.2 rad/s", drift(-0.2), since=HOLD),
    Case("axis pushed by -3 N m for ever", at(f"{PUSH}size = -3000\ncount = 0", HOLD), "feedback_torque",
         "land", 4, since=HOLD, seconds=4.0, falls=True),
    Case("encoder counts the wrong way from the start", drive(3, "encoder_reversed = true"),
         "following_error", "damp", 4, since=0),
    Case("axis pushed by 20 N m for 20 ms", at(f"{PUSH}size = 20000\ncount = 80"), since=AT + 80),
    Case("axis pushed by 8 N m for 20 ms", at(f"{PUSH}size = 8000\ncount = 80"), since=AT + 80),
    Case("axis pushed by -30 N m for ever", at(f"{PUSH}size = -30000\ncount = 0"), "speed", "land", 4, falls=True),
    Case("torque of a drive does not follow any more", at('kind = "torque_frozen"\nposition = 1'),
         "measured_torque", "zero", 2),
    Case("torque constant too small by the square root of 2", "drives.torque_constant = 2.1213\n",
         since=0),
    Case("torque constant too large by the square root of 2", "drives.torque_constant = 4.2426\n",
         since=0),
    Case("statusword frozen", at('kind = "status_frozen"\nposition = 1'), "none", unknown=(2,)),
    Case("drive does not obey disabling", at('kind = "control_ignored"\nposition = 1'), unknown=(2,)),
    Case("cable cut before the first drive in the landing", at('kind = "cable_cut"\nposition = 0', 28_000),
         unknown=ALL, since=28_000),
)  # fmt: skip


@pytest.mark.sample(6)
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_fault_ends_as_the_table_says(
    case: Case, hexapod_ssp: Path, tmp_path: Path, falls: Table
) -> None:
    fallen = free(Bench(hexapod_ssp, tmp_path), case.options, changes=case.changes, seconds=case.seconds)
    ran = fallen.ran
    row = fallen.fall(case.name, case.since)
    falls.add(row)
    trips = [e for e in ran.events if e["event"] == "trip"]
    found = (trips[0]["reason"], trips[0]["reaction"], trips[0]["axis"]) if trips else ("none", "–", None)
    assert found == (case.rule, case.stop, case.axis), ran.words
    assert row.unknown == case.unknown
    good = not trips and not case.unknown and not ran.one("summary")["landing_trip"]
    assert ran.code == (0 if good else 1)
    if not case.falls:
        fallen.ends_at_rest(case.since)

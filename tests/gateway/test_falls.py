"""Further faults of a machine with weight, one a case: rule, stop, fall, drives."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.gateway.bench import Bench, drive
from tests.gateway.fault_table import Table
from tests.gateway.test_landing import ALL, AT, at
from tests.gateway.test_refusals import REST_RAD, RESTS
from tests.gateway.weight import QUIET_S, TS, free

HOLD = 14_000
"""Cycle since enabling: the machine has lifted off, the reference stands still."""
RAD = 2**32 / math.tau
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
    holdable: bool = True
    """False: no drive can hold it, so only what is said is checked; the row shows the rest."""
    brakes: bool = True
    """False: a drive without power coasts."""


def fault(kind: str, cycle: int = AT, **options: object) -> str:
    """Options of the emulator for a fault."""
    lines = [f'kind = "{kind}"', *(f"{key} = {value}" for key, value in options.items())]
    return at("\n".join(lines), cycle)


def drift(speed: float) -> str:
    """An encoder that drifts [rad/s] from the hold on."""
    return fault("encoder_drift", HOLD, position=1, size=round(speed * RAD * TS))


def lost(cycle: int = HOLD, **often: object) -> str:
    """Replies that are lost, for ever unless a count is given."""
    return fault("frame_lost", cycle, **{"acting": '"after"', "count": 0} | often)


def short(**often: object) -> str:
    """A drive that ignores the process data, for ever."""
    return fault("wkc_short", HOLD, position=2, count=0, **often)


def push(torque: float, count: int = 0, cycle: int = AT) -> str:
    """A torque [N m] from outside on axis 4; count: cycles, 0 for ever."""
    return fault("push", cycle, position=3, size=round(1000 * torque), count=count)


LOST, SHORT = ("lost_frames", "zero"), ("working_counter", "zero")
LATE = 28_000
"""Cycle since enabling in a landing."""
LIFT = 6000
"""The same in a lift-off."""
FROZEN = "encoder frozen while the reference stands still"
UNLIKE = "torque of a drive does not follow any more"
REVERSED = "encoder counts the wrong way, and `rest_rad` is of it"
POSE = ("# [[pose]]", '[[pose]]\nsignal = "N_F.x.x_E.z"\nmin = 0.28\nmax = 0.315\n# [[pose]]')
FAST = ("# [[pose]]", '[[pose]]\nsignal = "N_F.xd.x_E.z"\nmin = -0.02\nmax = 0.02\n# [[pose]]')
ZERO = ('frozen_encoder = "damp"', 'frozen_encoder = "zero"\njump = "zero"')
"""All drives are disabled at once, as they are where no other can land the machine."""
WEAK = ("rated_torque_N_m = 9.0", "rated_torque_N_m = 0.7")
NOT_COMPARED = ("# unchecked = [0x608F]", "unchecked = [0x6075]")
"""A drive whose rated values are wrong, or are not there."""
QUICK = ("thermal_s = 10.0", "thermal_s = 1.0")
CASES = (
    Case("drive drops to SAFE-OP without an error flag", fault("safe_op", position=4, code=0),
         "al_state", "zero", 5),
    Case("emergency stop (STO) of all drives", fault("sto"), "drive_state", "zero", 1),
    Case("emergency stop (STO) of all drives, which coast", fault("sto"), "drive_state", "zero", 1,
         holdable=False, brakes=False),
    Case("an encoder freezes, and its drive coasts", fault("encoder_frozen", position=3),
         "frozen_encoder", "damp", 4, holdable=False, brakes=False),
    Case("an encoder freezes, and all drives coast, with `zero`",
         fault("encoder_frozen", position=3), "frozen_encoder", "zero", 4, changes=(ZERO,),
         holdable=False, brakes=False),
    Case("encoder jumps 0.8 mrad", fault("encoder_jump", position=1, size=546_000)),
    Case("working counter short, for ever", short(), *SHORT, since=HOLD),
    Case("working counter short, 2 cycles", fault("wkc_short", count=2)),
    Case("working counter short, 2 of every 3 cycles", short(burst=2, every=3), *SHORT, since=HOLD),
    Case("working counter short, 1 of every 5 cycles", short(burst=1, every=5), since=HOLD),
    Case("replies lost, 7 of every 8", lost(burst=7, every=8), *LOST, since=HOLD),
    Case("replies lost, 1 of every 5", lost(burst=1, every=5), since=HOLD),
    Case("replies lost, 30 %", lost(probability=0.3), *LOST, since=HOLD),
    Case("replies late by a cycle, 10 %", fault("frame_delayed", 1, count=0, probability=0.1),
         since=0),
    Case(FROZEN, fault("encoder_frozen", HOLD, position=3), "frozen_encoder", "damp", 4,
         since=HOLD),
    Case("encoder drifts by 0.05 rad/s", drift(0.05), since=HOLD),
    Case("encoder drifts by -0.2 rad/s", drift(-0.2), since=HOLD),
    Case("encoder drifts by 0.02 rad/s", drift(0.02), since=HOLD),
    Case(REVERSED, drive(3, "encoder_reversed = true"), "following_error", "damp", 4, since=0,
         changes=((REST_RAD, RESTS[1].replace("-0.29", "0.29")),)),
    Case("axis pushed by -3 N m for ever", push(-3, cycle=HOLD), "feedback_torque", "land", 4,
         since=HOLD, seconds=4.0, holdable=False),
    Case("axis pushed by 20 N m for 20 ms", push(20, 80), since=AT + 80),
    Case("axis pushed by 8 N m for 20 ms", push(8, 80), since=AT + 80),
    Case("axis pushed by -30 N m for ever", push(-30), "speed", "land", 4, holdable=False),
    Case(UNLIKE, fault("torque_frozen", position=1), "measured_torque", "damp", 2),
    Case("torque constant too small by the square root of 2, not compared",
         "drives.torque_constant = 2.1213\n", since=0, changes=(NOT_COMPARED,)),
    Case("torque constant too large by the square root of 2, not compared",
         "drives.torque_constant = 4.2426\n", since=0, changes=(NOT_COMPARED,)),
    Case("statusword frozen", fault("status_frozen", position=1), unknown=(2,)),
    Case("drive does not obey disabling", fault("control_ignored", position=1), unknown=(2,)),
    Case("platform would be faster than its limits", "", "pose", "land", since=0,
         changes=(FAST,)),
    Case("motors above their rated torque", "", "thermal", "land", 6, since=0,
         changes=(WEAK, QUICK)),
    Case("cable cut before the first drive in the landing", fault("cable_cut", LATE, position=0),
         unknown=ALL, since=LATE),
    Case("encoder jumps in the lift-off", fault("encoder_jump", LIFT, position=1), "jump", "damp",
         2, since=LIFT),
    Case("encoder frozen in the lift-off", fault("encoder_frozen", LIFT, position=3),
         "frozen_encoder", "damp", 4, since=LIFT),
    Case("encoder jumps, with `zero`", fault("encoder_jump", position=1), "jump", "zero", 2,
         changes=(ZERO,)),
    Case("encoder frozen, with `zero`", fault("encoder_frozen", position=3), "frozen_encoder",
         "zero", 4, changes=(ZERO,)),
    Case("two encoders freeze", fault("encoder_frozen", position=3)
         + fault("encoder_frozen", AT + 400, position=0), "frozen_encoder", "damp", 4),
    Case("drive fault in the lift-off", fault("drive_fault", LIFT, position=2), "drive_fault",
         "damp", 3, since=LIFT),
    Case("drive drops to SAFE-OP in the lift-off", fault("safe_op", LIFT, position=4), "al_state",
         "zero", 5, since=LIFT),
    Case("cable cut between drives 3 and 4 in the lift-off",
         fault("cable_cut", LIFT, position=3), *SHORT, unknown=ALL[3:], since=LIFT),
    Case("cable cut before the last drive", fault("cable_cut", position=5), *SHORT, unknown=(6,)),
    Case("cable cut after the last drive", fault("cable_cut", position=6)),
    Case("8 frames lost before they act", lost(AT, count=8, acting='"before"'), *LOST),
    Case("8 replies lost", lost(AT, count=8), *LOST),
    Case("7 frames lost before they act", lost(AT, count=7, acting='"before"')),
    Case("replies lost, 10 %", lost(1, probability=0.1), since=0),
    Case("frames lost, 1 %", lost(1, probability=0.01, acting='"before"'), since=0),
    Case("frames lost, 0.1 %", lost(1, probability=0.001, acting='"before"'), since=0),
    Case("an axis jams", fault("jam", position=3), "feedback_torque", "land", 4, seconds=5.0),
    Case("an axis jams in the lift-off", fault("jam", LIFT, position=3), "following_error", "damp",
         4, since=LIFT),
    Case("an axis jams while the reference stands still", fault("jam", HOLD, position=3),
         "feedback_torque", "land", 4, since=HOLD),
    Case("drives limit their torque to less than the weight", "drives.limit = 150\n",
         "measured_torque", "damp", 1, since=0),
)  # fmt: skip


@pytest.mark.sample(6)
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_fault_ends_as_the_table_says(
    case: Case, hexapod_ssp: Path, tmp_path: Path, falls: Table
) -> None:
    ends_as_said(case, Bench(hexapod_ssp, tmp_path), falls)


def ends_as_said(case: Case, bench: Bench, falls: Table) -> None:
    """Rule, stop, axis, axes that are not confirmed, exit code; the machine rests."""
    coasting = {} if case.brakes else {"braking": 0.0, "resting": QUIET_S}
    more = {"changes": case.changes, "seconds": case.seconds, **coasting}
    fallen = free(bench, case.options, **more)
    ran = fallen.ran
    row = fallen.fall(case.name, case.since)
    falls.add(row)
    trips = [e for e in ran.events if e["event"] == "trip"]
    actual = (
        (trips[0]["reason"], trips[0]["reaction"], trips[0]["axis"])
        if trips
        else ("none", "–", None)
    )
    assert actual == (case.rule, case.stop, case.axis), ran.words
    assert row.unknown == case.unknown
    good = not trips and not case.unknown and not ran.one("summary")["landing_trip"]
    assert ran.code == (0 if good else 1)
    if case.holdable:
        fallen.ends_at_rest(case.since)

"""Faults on the cable and in the FMUs, and the cycle in which the gateway trips."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from flexhex.ssp.read import read_ssp
from tests.gateway.archives import Spoil, spoiled
from tests.gateway.bench import Bench, Ran
from tests.gateway.fault_table import Row, Table

ANY_STEP = ("torque_step_N_m = 2.0", "torque_step_N_m = 0.0")
"""A jump of the reference is a step of the torque; without that rule it is a following error."""

AT = 9000
"""Cycle of every fault: 2.25 s, in the first move of the reference."""


@dataclass(frozen=True)
class Case:
    """A fault of the emulated drives, the rule that must see it, and when: cycles after it."""

    name: str
    fault: str
    reason: str
    after: int
    axis: int | None = None
    stop: str = "zero"
    changes: tuple[tuple[str, str], ...] = ()


CASES = (
    Case("drive fault", 'kind = "drive_fault"\nposition = 2', "drive_fault", 0, 3, "damp"),
    Case("encoder jumps 1.5 mrad", 'kind = "encoder_jump"\nposition = 1', "jump", 0, 2, "damp"),
    Case("drive drops to SAFE-OP", 'kind = "safe_op"\nposition = 4', "al_state", 0, 5),
    Case("working counter short, 3 cycles", 'kind = "wkc_short"\ncount = 3', "working_counter", 2),
    Case("cable cut before the first drive", 'kind = "cable_cut"\nposition = 0', "lost_frames", 7),
    Case("cable cut between drives", 'kind = "cable_cut"\nposition = 3', "working_counter", 2),
    Case("cable cut before the last", 'kind = "cable_cut"\nposition = 5', "working_counter", 2),
    Case("8 frames lost before they act", 'kind = "frame_lost"\ncount = 8', "lost_frames", 7),
    Case("8 replies lost", 'kind = "frame_lost"\nacting = "after"\ncount = 8', "lost_frames", 7),
)  # fmt: skip


def faults(*tables: str) -> str:
    """Options of the emulator with faults that begin at AT."""
    return "".join(f"[[fault]]\ncycle = {AT}\n{table}\n" for table in tables)


def struck(fault: str, cycles: int) -> list[int]:
    """Cycles from AT in which a fault acts, by the emulator's rule (SplitMix64 of seed 0)."""
    known = dict(line.split(" = ") for line in fault.splitlines())
    count = int(known.get("count", "1")) or cycles
    probability = float(known.get("probability", "1"))
    return [n for n in range(AT, min(AT + count, cycles)) if chance(n) < probability]


def chance(cycle: int) -> float:
    """Uniform in [0, 1) for the first fault of the list in a cycle."""
    mixed = 0
    for value in (0, cycle):
        mixed = mix(mixed + mix(value))
    return (mixed >> 11) / 2**53


def mix(value: int) -> int:
    """One step of SplitMix64 [Steele et al. 2014]."""
    z = (value + 0x9E3779B97F4A7C15) % 2**64
    z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9 % 2**64
    z = (z ^ z >> 27) * 0x94D049BB133111EB % 2**64
    return z ^ z >> 31


def time_ms(ran: Ran, since: int = AT) -> float:
    """From the fault to the frame that carries no torque [ms]."""
    trip = ran.one("trip")
    return float((trip["cycle"] + trip["cycles_to_zero"] - since) * 0.25)


@pytest.mark.sample(4)
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_fault_trips_at_its_cycle(
    case: Case, hexapod_ssp: Path, tmp_path: Path, table: Table
) -> None:
    ran = Bench(hexapod_ssp, tmp_path).run(options=faults(case.fault), changes=case.changes)
    trip = ran.one("trip")
    assert ran.code == 1
    assert (trip["reason"], trip["axis"], trip["cycle"]) == (
        case.reason,
        case.axis,
        AT + case.after,
    )
    assert trip["reaction"] == case.stop
    assert np.all(ran.kept["tau"][AT + case.after] != 0)
    if case.stop == "zero":
        # the very next frame carries no torque
        assert trip["cycles_to_zero"] == 1
        assert np.all(ran.kept["tau"][AT + case.after + 1 :] == 0)
    # nobody asked for a reset: what is faulty stays so
    faulty = [e["position"] for e in ran.happened("drive") if e["to"] == "fault"]
    assert not [e for e in ran.happened("drive") if e["from"] == "fault"]
    assert faulty == ([case.axis - 1] if case.reason == "drive_fault" and case.axis else faulty)
    table.add(Row(case.name, trip["reason"], case.stop, trip["cycle"] - AT, time_ms(ran)))


def test_frozen_encoder_trips_when_the_reference_has_moved_on(
    hexapod_ssp: Path, tmp_path: Path, table: Table
) -> None:
    options = faults('kind = "encoder_frozen"\nposition = 3')
    ran = Bench(hexapod_ssp, tmp_path).run(options=options)
    trip = ran.one("trip")
    assert (trip["reason"], trip["axis"]) == ("frozen_encoder", 4)
    theta, r = ran.kept["theta"][:, 3], ran.kept["r"][:, 3]
    last = int(np.flatnonzero(np.diff(theta[: AT + 5]))[-1]) + 1
    moved = np.abs(r - r[last]) > 0.0003
    moved[: last + 12] = False
    assert trip["cycle"] == int(np.flatnonzero(moved)[0])
    assert trip["reaction"] == "damp"
    table.add(Row("encoder frozen", trip["reason"], "damp", trip["cycle"] - AT, time_ms(ran)))


def test_reference_that_jumps_is_a_quick_stop_without_a_fault(
    hexapod_ssp: Path, tmp_path: Path, table: Table
) -> None:
    bad = spoiled(hexapod_ssp, Spoil("reference", AT, "set", "r[2]", 0.3, 400), tmp_path / "b.ssp")
    # that it is a step of the torque, too, is not judged here
    changes = (('following_error = "land"', 'following_error = "quick_stop"'), ANY_STEP)
    ran = Bench(bad, tmp_path).run(plant=hexapod_ssp, changes=changes)
    trip = ran.one("trip")
    assert (trip["reason"], trip["axis"], trip["limit"]) == ("following_error", 2, 0.05)
    # r is shown one cycle after its step, e one after its own; what lies between two samples of
    # the delayed r begins with the first of them
    delay = read_ssp(hexapod_ssp).instance("feedback").parameters["reference_delay"]
    assert trip["cycle"] - AT == 2 + math.floor(delay)
    assert trip["cycles_to_zero"] == 1
    last = {e["position"]: e for e in ran.happened("drive")}
    assert all(e["to"] != "operation enabled" and e["error"] == 0 for e in last.values())
    assert [e for e in ran.happened("drive") if e["to"] == "quick stop active"]
    assert not ran.happened("watchdog")
    cycles = trip["cycle"] - AT
    table.add(Row("reference jumps by 0.3 rad", trip["reason"], "quick stop", cycles, time_ms(ran)))


LOST, AFTER = 'kind = "frame_lost"', '\nacting = "after"'


OFTEN = "\ncount = 0\nprobability = "


@pytest.mark.sample(4)
@pytest.mark.parametrize(
    ("name", "fault", "seconds"),
    [
        ("frames lost, 0.1 %", f"{LOST}{OFTEN}0.001", 4.0),
        ("frames lost, 1 %", f"{LOST}{OFTEN}0.01", 4.0),
        ("frames lost, 10 %", f"{LOST}{OFTEN}0.1", 3.0),
        ("replies lost, 10 %", f"{LOST}{AFTER}{OFTEN}0.1", 3.0),
        ("frames delayed, 1 %", f'kind = "frame_delayed"{OFTEN}0.01', 3.0),
        ("frames out of order, 1 %", f'kind = "frame_reordered"{OFTEN}0.01', 3.0),
        ("cable cut after the last drive", 'kind = "cable_cut"\nposition = 6', 2.5),
        ("working counter short, 2 cycles", 'kind = "wkc_short"\ncount = 2', 2.5),
        ("7 frames lost", f"{LOST}\ncount = 7", 2.5),
    ],
)  # fmt: skip
def test_fault_is_survived_and_counted(
    name: str, fault: str, seconds: float, hexapod_ssp: Path, tmp_path: Path, table: Table
) -> None:
    bench = Bench(hexapod_ssp, tmp_path)
    ran = bench.run(options=faults(fault), seconds=seconds)
    assert ran.code == 0, ran.words
    summary, table_of = ran.one("summary"), ran.table
    running = table_of["phase"] == 1
    answered, counter = table_of["answered"][running], table_of["working_counter"][running]
    missed = np.flatnonzero((answered == 0) | (counter != 18))
    # no device is connected after the last drive
    wanted = [] if "position = 6" in fault else struck(fault, len(answered))
    # a slow computer may lose more by itself
    assert len(wanted) > 0 or "position = 6" in fault
    assert set(wanted) <= set(missed)
    assert summary["lost"] + summary["short"] == len(missed)
    assert max(summary["largest_error_rad"]) < 0.01
    assert not ran.happened("watchdog")
    table.add(Row(name, "none", "continues", None, None))


def test_duplicates_do_not_change_one_bit(hexapod_ssp: Path, tmp_path: Path, table: Table) -> None:
    bench = Bench(hexapod_ssp, tmp_path)
    twice = bench.run(options=faults(f'kind = "frame_duplicated"{OFTEN}0.1'))
    assert twice.code == 0, twice.words
    theta = twice.table["theta"]
    plain = bench.run(seconds=2.5).table["theta"]
    assert np.array_equal(theta, plain)
    happened = twice.happened("stopped")[0]["faults"][0]["count"]
    # the last duplicate may arrive when nobody listens any more
    assert happened - 1 <= twice.one("summary")["duplicated"] <= happened
    assert happened > 50
    table.add(Row("frames duplicated, 10 %", "none", "continues", None, None))


@pytest.mark.parametrize(
    ("code", "said"),
    [
        (0x1A, "AL status code 0x001a (synchronisation error): clocks or cycle jitter too much"),
        (0x8001, "AL status code 0x8001: look it up in the manual of the drive"),
    ],
)
def test_why_a_drive_left_op_is_reported_in_words(
    code: int, said: str, hexapod_ssp: Path, tmp_path: Path
) -> None:
    """In the run and in the landing after it."""
    fault = f'kind = "safe_op"\nposition = 4\ncode = {code}'
    bench = Bench(hexapod_ssp, tmp_path)
    trip = bench.run(options=faults(fault)).one("trip")
    assert (trip["reason"], trip["axis"]) == ("al_state", 5)
    assert trip["detail"].startswith(said)
    assert said in (tmp_path / "run-trip.csv").read_text()
    ended = bench.run(options=faults(fault), seconds=(AT - 200) * 0.00025)
    assert ended.one("summary")["landing_detail"].startswith(said)
    text = f"during the landing axis 5: AL status 0x04, expected 0x08 (OP) (cycle {AT}): {said}"
    assert text in ended.words

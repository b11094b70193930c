"""FMUs that go wrong: at which cycle the gateway trips, and what a trip keeps."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from tests.gateway.archives import Spoil, spoiled
from tests.gateway.bench import Bench, columns
from tests.gateway.fault_table import Row, Table
from tests.gateway.test_faults import AT, faults, time_ms


@dataclass(frozen=True)
class Broken:
    """An FMU that goes wrong at a step, and the cycle in which the gateway must see it."""

    name: str
    spoil: Spoil
    reason: str
    cycle: int
    said: str
    changes: tuple[tuple[str, str], ...] = ()


BROKEN = (
    Broken("FMU output NaN", Spoil("feedback", AT, "set", "tau[2]", math.nan), "not_finite", AT,
           "feedback.tau[2] = NaN"),
    Broken("FMU returns an error", Spoil("F", AT // 2, "error"), "fmu_error", AT + 1,
           "F: fmi2DoStep"),
    Broken("FMU reports a fault", Spoil("N_E", AT // 2, "set", "fault", 2.0), "fmu_fault", AT + 1,
           "N_E.fault = 2 (out_of_reach)"),
    Broken("FMU overruns", Spoil("feedback", AT, "sleep", value=1.5), "fmu_overrun", AT,
           "feedback: its step at base step"),
    Broken("estimator late", Spoil("K", 75, "sleep", value=2.5), "late_thread", 76 * 120 - 1,
           "K: fed at base step", (('late = "hold"', 'late = "trip"'),)),
)  # fmt: skip


@pytest.mark.sample(2)
@pytest.mark.parametrize("broken", BROKEN, ids=lambda broken: broken.name)
def test_broken_fmu_trips_in_its_cycle(
    broken: Broken, hexapod_ssp: Path, tmp_path: Path, table: Table
) -> None:
    bad = spoiled(hexapod_ssp, broken.spoil, tmp_path / "bad.ssp")
    bench = Bench(bad, tmp_path)
    ran = bench.run(plant=hexapod_ssp, changes=broken.changes)
    trip = ran.one("trip")
    assert (trip["reason"], trip["cycle"]) == (broken.reason, broken.cycle), ran.words
    assert broken.said in trip["detail"], "says which component, and what is wrong"
    # the landing takes none of the FMUs' numbers: its torques are finite and below its limit
    tau = ran.kept["tau"][ran.kept["phase"] == 4]
    assert len(tau) == trip["cycles_to_zero"] - 1
    assert np.all(np.abs(tau) <= 6.0)
    assert trip["cycles_to_zero"] > 2800, "braking and two pauses"
    table.add(Row(broken.name, trip["reason"], "land", 0, time_ms(ran, broken.cycle)))


def test_estimator_that_is_late_is_held_and_counted(hexapod_ssp: Path, tmp_path: Path) -> None:
    bad = spoiled(hexapod_ssp, Spoil("K", 75, "sleep", value=2.5), tmp_path / "bad.ssp")
    ran = Bench(bad, tmp_path).run(plant=hexapod_ssp)
    assert ran.code == 0, ran.words
    assert ran.one("summary")["late_threads"] >= 1


def test_trip_keeps_the_rows_before_it(hexapod_ssp: Path, tmp_path: Path) -> None:
    options = faults('kind = "drive_fault"')
    ran = Bench(hexapod_ssp, tmp_path).run(options=options)
    kept = Path(ran.one("summary")["before_trip"])
    trip = re.compile(r"# trip: drive_fault: axis 1: .*0x7305.*\(cycle 9000\)")
    assert any(trip.match(line) for line in kept.read_text().splitlines())
    rows = len(ran.table["time"])
    assert np.array_equal(columns(kept)["theta"][:rows], ran.table["theta"])
    assert len(columns(kept)["time"]) == rows + ran.one("trip")["cycles_to_disabled"]


def test_trip_keeps_so_much_before_it_and_the_reaction_besides(
    hexapod_ssp: Path, tmp_path: Path
) -> None:
    """0.5 s are 2000 rows before the trip, and all rows of the landing."""
    bad = spoiled(hexapod_ssp, Spoil("feedback", AT, "error"), tmp_path / "bad.ssp")
    changes = (("keep_s = 5.0", "keep_s = 0.5"),)
    ran = Bench(bad, tmp_path).run(plant=hexapod_ssp, changes=changes)
    phase, cycle = ran.kept["phase"], ran.kept["cycle"]
    assert np.count_nonzero(phase == 1) == 2000
    assert (cycle[phase == 1][-1], ran.one("trip")["cycle"]) == (AT, AT)
    landing = np.count_nonzero(phase == 4)
    assert landing == ran.one("trip")["cycles_to_zero"] - 1
    assert len(phase) == 2000 + landing + np.count_nonzero(phase == 2)

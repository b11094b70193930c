"""The computer stands still for 10 ms, of a machine with weight: in lift-off, run and landing."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.gateway.bench import Bench
from tests.gateway.fault_table import Table
from tests.gateway.test_falls import LATE, LIFT, Case, ends_as_said, fault
from tests.gateway.test_landing import AT

NAME = "computer stands still for 10 ms"
CYCLES = 40
PHASES = {"": AT, " in the lift-off": LIFT, " in the landing": LATE}
PATIENT = ("watchdog_ms = 5 ", "watchdog_ms = 20 ")
"""The drives wait longer than the computer stands still."""
ALLOWED = ("overrun_us = 2000", "overrun_us = 20000")


def stall(cycle: int) -> str:
    """40 cycles go by without a frame."""
    return fault("stall", cycle, count=CYCLES)


CASES = (
    *(Case(NAME + words, stall(cycle), "al_state" if cycle != LATE else "none",
           "zero" if cycle != LATE else "–", 1 if cycle != LATE else None, since=cycle)
      for words, cycle in PHASES.items()),
    *(Case(f"{NAME}{words}, watchdog 20 ms", stall(cycle), "overrun" if cycle != LATE else "none",
           "land" if cycle != LATE else "–", since=cycle, changes=(PATIENT,))
      for words, cycle in PHASES.items()),
    *(Case(f"{NAME}{words}, watchdog and `overrun_us` 20 ms", stall(cycle), since=cycle,
           changes=(PATIENT, ALLOWED))
      for words, cycle in PHASES.items()),
)  # fmt: skip


@pytest.mark.sample(4)
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_standstill_ends_as_the_table_says(
    case: Case, hexapod_ssp: Path, tmp_path: Path, falls: Table
) -> None:
    ends_as_said(case, Bench(hexapod_ssp, tmp_path), falls)

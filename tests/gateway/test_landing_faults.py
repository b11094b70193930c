"""Faults during a landing, and a bad cable from lift-off to landing."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from tests.gateway.bench import Bench
from tests.gateway.fault_table import Table
from tests.gateway.test_landing import at
from tests.gateway.weight import free

LATE: dict[str, tuple[str, list[int], Callable[[str], bool]]] = {
    "cable cut in the landing": (
        'kind = "cable_cut"\nposition = 3', [4, 5, 6], lambda text: "working counter" in text,
    ),
    "drive fault in the landing": (
        'kind = "drive_fault"\nposition = 2', [], lambda text: "drive fault 0x7305" in text,
    ),
    "encoder jumps in the landing": (
        'kind = "encoder_jump"\nposition = 1', [], lambda text: "jumped" in text,
    ),
}  # fmt: skip


@pytest.mark.sample(2)
@pytest.mark.parametrize("name", LATE)
def test_fault_in_the_landing_of_a_good_run_is_judged(
    name: str, hexapod_ssp: Path, tmp_path: Path, falls: Table
) -> None:
    fault, unknown, said = LATE[name]
    fallen = free(Bench(hexapod_ssp, tmp_path), at(fault, 28_000))
    summary = fallen.ran.one("summary")
    assert fallen.ran.code == 1
    assert said(summary["landing_trip"])
    assert summary["not_disabled"] == unknown
    fallen.ends_at_rest(28_000)
    falls.add(fallen.fall(name, 28_000))


GO_ON = {
    "frames lost, 10 %": 'kind = "frame_lost"\ncount = 0\nprobability = 0.1',
    "frames out of order, 1 %": 'kind = "frame_reordered"\ncount = 0\nprobability = 0.01',
    "frames duplicated, 10 %": 'kind = "frame_duplicated"\ncount = 0\nprobability = 0.1',
}


@pytest.mark.sample(2)
@pytest.mark.parametrize("name", GO_ON)
def test_bad_cable_from_lift_off_to_landing_stops_nothing(
    name: str, hexapod_ssp: Path, tmp_path: Path, falls: Table
) -> None:
    fallen = free(Bench(hexapod_ssp, tmp_path), at(GO_ON[name], 1), seconds=1.0)
    assert fallen.ran.code == 0, fallen.ran.words
    fallen.ends_at_rest(0)
    falls.add(fallen.fall(name, 0))

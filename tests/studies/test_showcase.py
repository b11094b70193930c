"""The showcase's machines are drawn as told, and its table hides no failure."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from flexhex.fmus.common.machine_file import load_machine, truth_file
from flexhex.fmus.machine.truth import load_truth
from studies.showcase import judged, table
from studies.showcase_machines import INSIDE, LARGE, OUTSIDE, SMALL, drawn, write_machine
from tests.conftest import MACHINE_FILE


def test_two_of_the_machines_hide_what_is_outside_the_library() -> None:
    for seed in (1, 41, 99):
        kinds = [{h.kind for h in drawn(seed, k, 20)} for k in range(1, 21)]
        outside = [found for found in kinds if found & set(OUTSIDE)]
        assert sorted(map(tuple, outside)) == [("bump",), ("inertia",)]
        assert all(found <= set(INSIDE) for found in kinds if found not in outside)
        assert kinds != [{h.kind for h in drawn(seed + 1, k, 20)} for k in range(1, 21)]


def test_drawn_machine_is_written_as_its_truth(tmp_path: Path) -> None:
    for number in range(1, 21):
        hidden = drawn(7, number, 20)
        path = write_machine(MACHINE_FILE, tmp_path / str(number), hidden, 700 + number)
        assert load_machine(path) == load_machine(MACHINE_FILE)
        truth = load_truth(truth_file(path))
        assert truth.seed == 700 + number
        assert [(h.kind, h.axes, dict(h.values)) for h in truth.hidden] == [
            (h.kind, h.axes, h.values) for h in hidden
        ]
        assert all(SMALL <= h.size <= LARGE for h in hidden)


def line(hidden: list[str], said: list[tuple[str, list[str]]]) -> dict[str, Any]:
    entries = [{"kind": kind, "axes": [1], "size": 0.01} for kind in hidden]
    effects = [{"id": id, "axes": [1], "rivals": rivals} for id, rivals in said]
    return {"number": 3, "hidden": entries, "diagnosis": {"effects": effects}}


@pytest.mark.parametrize(
    ("hidden", "said", "wanted"),
    [
        (["lugre"], [("stribeck_friction", [])], "right"),
        (["lugre"], [("second_hysteresis", [])], "near"),
        (["lugre", "drag"], [("second_hysteresis", [])], "partly"),
        (["drag"], [("second_hysteresis", [])], "wrong"),
        (["cubic"], [("cable_force", ["cubic_stiffness"])], "right, in a set"),
        (["cubic", "drag"], [("cubic_stiffness", [])], "partly"),
        (["cubic"], [], "missed"),
        (["cubic"], [("drive_lag", [])], "wrong"),
        (["cubic"], [("cubic_stiffness", []), ("drive_lag", [])], "one wrong"),
        (["bump"], [], "right"),
        (["bump"], [("cogging_harmonic", [])], "wrong"),
    ],
)
def test_showcase_judges_names(
    hidden: list[str], said: list[tuple[str, list[str]]], wanted: str
) -> None:
    assert judged(line(hidden, said)) == wanted


def test_table_shows_failures() -> None:
    broken = {**line(["cubic"], []), "error": "LogError: too short | no"}
    (row,) = [text for text in table([broken]).splitlines() if text.startswith("| 3 |")]
    assert "LogError: too short / no" in row
    assert "| failed |" in row

"""The showcase's machines are drawn as told, and its table hides no failure."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from flexhex.fmus.common.machine_file import load_machine, truth_file
from flexhex.fmus.machine.truth import load_truth
from results.tables import machines as table
from studies.showcase import judged
from studies.showcase_machines import INSIDE, LARGE, OUTSIDE, SMALL, drawn, write_machine
from tests.conftest import MACHINE_FILE


def test_two_of_the_machines_hide_what_is_outside_the_library() -> None:
    for seed in (1, 41, 99):
        kinds = [{h.kind for h in drawn(seed, k, 20)} for k in range(1, 21)]
        outside = [machine for machine in kinds if machine & set(OUTSIDE)]
        assert sorted(map(tuple, outside)) == [("bump",), ("inertia",)]
        assert all(machine <= set(INSIDE) for machine in kinds if machine not in outside)
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


Said = list[tuple[str, list[int], list[str]]]


def line(hidden: list[tuple[str, list[int]]], said: Said, verdict: str = "named") -> dict[str, Any]:
    entries = [{"kind": kind, "axes": axes, "size": 0.01} for kind, axes in hidden]
    effects = [{"id": id, "axes": axes, "rivals": rivals} for id, axes, rivals in said]
    diagnosis = {"verdict": verdict, "effects": effects, "changed": []}
    return {"number": 3, "hidden": entries, "diagnosis": diagnosis}


LUGRE, DRAG, CUBIC = ("lugre", [1]), ("drag", [1]), ("cubic", [1, 2])


@pytest.mark.parametrize(
    ("hidden", "said", "wanted"),
    [
        ([LUGRE], [("stribeck_friction", [1], [])], "right"),
        ([LUGRE], [("stribeck_friction", [2], [])], "right_name_wrong_axes"),
        ([LUGRE], [("stribeck_friction", [1], ["load_friction"])], "ambiguous"),
        ([LUGRE], [("second_hysteresis", [1], [])], "right, near"),
        ([LUGRE, DRAG], [("second_hysteresis", [1], [])], "some, near"),
        ([DRAG], [("second_hysteresis", [1], [])], "wrong"),
        ([CUBIC], [("cubic_stiffness", [1], [])], "right_name_wrong_axes"),
        ([CUBIC], [("cable_force", [1, 2], ["cubic_stiffness"])], "ambiguous"),
        ([CUBIC, DRAG], [("cubic_stiffness", [1, 2], [])], "some"),
        ([CUBIC, DRAG], [("cubic_stiffness", [1, 2], []), ("quadratic_drag", [1], [])], "all"),
        ([CUBIC, ("bump", [1])], [("cubic_stiffness", [1, 2], [])], "right"),
        ([CUBIC], [], "missed"),
        ([CUBIC], [("drive_lag", [1, 2], [])], "wrong"),
        ([CUBIC], [("cubic_stiffness", [1, 2], []), ("drive_lag", [1], [])], "wrong"),
        ([("bump", [1])], [("cogging_harmonic", [1], [])], "wrong"),
    ],
)
def test_showcase_judges_names_axes_and_sets(
    hidden: list[tuple[str, list[int]]], said: Said, wanted: str
) -> None:
    assert judged(line(hidden, said)) == wanted


@pytest.mark.parametrize(
    ("verdict", "wanted"),
    [("unknown", "detected"), ("none", "missed"), ("changed", "missed")],
)
def test_silence_about_an_effect_outside_the_library_is_no_success(
    verdict: str, wanted: str
) -> None:
    assert judged(line([("bump", [1])], [], verdict)) == wanted


def test_table_shows_failures() -> None:
    broken = {**line([CUBIC], []), "error": "LogError: too short | no", "judged": "failed"}
    (row,) = [text for text in table([broken]).splitlines() if text.startswith("| 3 |")]
    assert "LogError: too short / no" in row
    assert "| failed |" in row

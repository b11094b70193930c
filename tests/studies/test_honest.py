"""The honest scorer: every outcome, coverage, calibration, tables; and the runner's store."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from studies import honest_tables as tables
from studies.honest import Outcome, score
from studies.mujoco import study

Found = dict[str, Any]


def effect(id: str, axes: Sequence[int], *rivals: str, **intervals: tuple[float, float]) -> Found:
    """An effect of an answer."""
    rows = {name: {"value": 0.0, "ci95": list(ends)} for name, ends in intervals.items()}
    return {"id": id, "axes": list(axes), "rivals": list(rivals), "parameters": rows}


def said(verdict: str, *effects: Found, changed: Sequence[str] = ()) -> Found:
    """An answer."""
    rows = [{"parameter": name} for name in changed]
    return {"verdict": verdict, "effects": list(effects), "changed": rows}


def hides(id: str, axes: Sequence[int], observable: float = 0.02, inside: bool = True) -> Found:
    """A hidden effect of a truth."""
    return {
        "id": id,
        "accept": [id, f"{id}_too"] if inside else [],
        "inside": inside,
        "axes": list(axes),
        "size": 2 * observable,
        "observable": observable,
        "parameters": {"F": {"value": [0.5] * len(axes), "unit": "N m"}},
    }


def truth(category: str, *hidden: Found, changed: Sequence[Found] = ()) -> Found:
    """A sealed truth."""
    head = {"seed": 1, "family": "mujoco", "machine": "arm", "category": category}
    return {**head, "hidden": list(hidden), "changed": list(changed)}


DRAG, FAINT = truth("single", hides("drag", [2])), truth("single", hides("drag", [2], 0.003))
DENT = truth("outside", hides("dent", [1], 0.02, False))
SMALL_DENT = truth("outside", hides("dent", [1], 0.009, False))
TWO = truth("pair", hides("drag", [2]), hides("bend", [4]))
HEAVY = truth("changed", changed=[{"kind": "mass", "accept": ["link[2]."]}])
LOAD = truth("payload", changed=[{"kind": "payload", "accept": ["payload"], "announced": True}])
NONE, GAP, DUMB = said("none"), said("unknown"), said("cannot tell")


@pytest.mark.parametrize(
    ("hidden", "answer", "outcome"),
    [
        (truth("nothing"), NONE, "silent"),
        (truth("nothing"), said("changed", changed=["o[1]"]), "silent"),
        (truth("nothing"), GAP, "unknown"),
        (truth("nothing"), said("named", effect("drag", [1])), "false_alarm"),
        (LOAD, NONE, "silent"),
        (LOAD, said("named", effect("drag", [1])), "false_alarm"),
        (DRAG, said("named", effect("drag", [2])), "right"),
        (DRAG, said("named", effect("drag_too", [2])), "right"),
        (DRAG, said("set", effect("drag", [2], "drag_too")), "right"),
        (DRAG, said("named", effect("drag", [2, 3])), "right_name_wrong_axes"),
        (DRAG, said("named", effect("drag", [3])), "right_name_wrong_axes"),
        (DRAG, said("set", effect("bend", [2], "drag")), "in_set"),
        (DRAG, said("set", effect("bend", [2], "a", "b", "drag")), "wrong"),
        (DRAG, said("named", effect("bend", [2])), "wrong"),
        (DRAG, said("named", effect("drag", [2]), effect("bend", [2])), "wrong"),
        (DRAG, NONE, "missed"),
        (DRAG, said("changed", changed=["o[1]"]), "missed"),
        (DRAG, DUMB, "cannot_tell"),
        (DRAG, GAP, "unknown"),
        (FAINT, NONE, "silent"),
        (FAINT, DUMB, "silent"),
        (FAINT, said("named", effect("bend", [2])), "wrong"),
        (DENT, GAP, "detected"),
        (DENT, NONE, "missed"),
        (DENT, said("changed", changed=["o[1]"]), "missed"),
        (DENT, DUMB, "cannot_tell"),
        (DENT, said("named", effect("drag", [1])), "wrong"),
        (SMALL_DENT, NONE, "silent"),
        (TWO, said("named", effect("drag", [2]), effect("bend", [4])), "both"),
        (TWO, said("set", effect("drag", [2], "x"), effect("bend", [4])), "both"),
        (TWO, said("named", effect("bend", [4])), "one"),
        (TWO, said("named", effect("bend", [4]), effect("x", [1])), "one+wrong"),
        (TWO, said("named", effect("x", [1])), "none+wrong"),
        (TWO, said("named", effect("drag", [2]), effect("bend", [3, 4])), "one"),
        (TWO, NONE, "none"),
        (TWO, GAP, "unknown"),
        (HEAVY, said("changed", changed=["link[2].m"]), "right"),
        (HEAVY, said("changed", changed=["link[1].m"]), "wrong"),
        (HEAVY, said("named", effect("drag", [2]), changed=["link[2].m"]), "wrong"),
        (HEAVY, NONE, "missed"),
        (HEAVY, GAP, "unknown"),
    ],
)
def test_outcome_of_an_answer(hidden: Found, answer: Found, outcome: str) -> None:
    assert score(answer, hidden).outcome == outcome


@pytest.mark.parametrize("error", ["refused", "failed"])
def test_no_answer_is_an_outcome_of_its_own(error: str) -> None:
    assert score(None, DRAG, error).outcome == error
    with pytest.raises(ValueError, match="refused or failed"):
        score(None, DRAG, "")


@pytest.mark.parametrize(
    "answer",
    [
        {"effects": [], "changed": []},
        {"verdict": "none", "effects": None, "changed": []},
        {"verdict": "named", "effects": [{"axes": [1]}], "changed": []},
    ],
)
def test_an_answer_of_another_form_is_refused(answer: Found) -> None:
    with pytest.raises(ValueError, match="answer: "):
        score(answer, DRAG)


def test_intervals_are_compared_with_the_true_values() -> None:
    narrow = score(said("named", effect("drag", [2], F=(0.4, 0.6))), DRAG)
    wide = score(said("named", effect("drag", [2], F=(0.6, 0.7))), DRAG)
    other = score(said("named", effect("bend", [2], F=(0.4, 0.6))), DRAG)
    assert narrow.covered == {"drag.F[2]": True}
    assert wide.covered == {"drag.F[2]": False}
    assert other.covered == {}
    assert tables.coverage([narrow, wide, other]) == (1, 2)


def test_calibration_sets_the_confidence_beside_what_was_right() -> None:
    right = score(said("named", effect("drag", [2])), DRAG)
    wrong = score(said("named", effect("bend", [2])), DRAG)
    sure = [replace(right, confidence=0.95), replace(wrong, confidence=0.95)]
    rows = tables.calibration([*sure, replace(wrong, confidence=0.3), right])
    assert rows == [(0.3, 0, 1), (0.95, 1, 2)]
    assert tables.calibration([replace(right, confidence=1.0)]) == [(1.0, 1, 1)]


def test_tables_count_by_category_and_size() -> None:
    outcomes = [score(NONE, DRAG), score(GAP, DRAG), score(NONE, FAINT), score(NONE, SMALL_DENT)]
    found = {(r.category, r.size, r.outcome): (r.hits, r.n) for r in tables.rows(outcomes)}
    assert found["single", "observable", "missed"] == (1, 2)
    assert found["single", "fainter", "silent"] == (1, 1)
    assert found["outside", "fainter", "silent"] == (1, 1)
    assert "1 of 2 (95 % interval 9 to 91 %)" in tables.text(outcomes)


ENGINE = """
def right(paths, test_paths, machine_file):
    return {"verdict": "none", "effects": [], "changed": [], "shown": {"large": 1}}

def faulty(paths, test_paths, machine_file):
    raise RuntimeError("no idea")
"""


def test_a_study_goes_on_where_it_stopped(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "toy_engine.py").write_text(ENGINE)
    monkeypatch.setenv("PYTHONPATH", f"{Path.cwd()}:{tmp_path}")
    monkeypatch.setattr("studies.mujoco.draw.MOST_STEPS", 3000)
    store = tmp_path / "store.jsonl"
    common = ["--store", str(store), "--category", "nothing"]
    assert study.main(["--seeds", "8:9", "--engine", "toy_engine:right", *common]) == 0
    first = store.read_text()
    with store.open("a") as file:
        file.write('{"seed": 9, "outc')
    assert study.main(["--seeds", "8:9", "--engine", "toy_engine:right", *common]) == 0
    assert store.read_text() == first
    assert "silent" in capsys.readouterr().out
    (row,) = study.read(store)
    assert row["answer"] == {"verdict": "none", "effects": [], "changed": []}
    assert row["peak_bytes"] > 1e6
    assert isinstance(study.outcome_of(row), Outcome)
    assert study.main(["--seeds", "8:9", "--engine", "toy_engine:faulty", *common]) == 1
    assert study.read(store)[1]["outcome"]["outcome"] == "failed"
    assert "no idea" in study.read(store)[1]["error"]


def test_a_store_of_another_study_and_test_seeds_are_refused(tmp_path: Path) -> None:
    store = tmp_path / "store.jsonl"
    store.write_text(json.dumps({"task": ["seed", 1]}) + "\n")
    with pytest.raises(ValueError, match=":1: no case of this study"):
        study.read(store)
    with pytest.raises(SystemExit):
        study.main(["--seeds", "9999:10001", "--store", str(tmp_path / "new.jsonl")])

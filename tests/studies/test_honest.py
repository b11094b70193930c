"""The scorer: every outcome, intervals, what is true of plain axes, the table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import pytest

from studies import honest_tables as tables
from studies.honest import Outcome, score

Data = dict[str, Any]


def effect(id: str, axes: Sequence[int], *rivals: str, **intervals: tuple[float, float]) -> Data:
    """An effect of an answer."""
    rows = {name: {"value": sum(ends) / 2, "ci95": list(ends)} for name, ends in intervals.items()}
    return {"id": id, "axes": list(axes), "rivals": list(rivals), "parameters": rows}


def said(verdict: str, *effects: Data, changed: Sequence[str] = ()) -> Data:
    """An answer."""
    rows = [{"parameter": name} for name in changed]
    return {"verdict": verdict, "effects": list(effects), "changed": rows}


def hides(id: str, axes: Sequence[int], observable: float = 0.02, inside: bool = True) -> Data:
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


def truth(category: str, *hidden: Data, changed: Sequence[Data] = ()) -> Data:
    """A sealed truth."""
    head = {"seed": 1, "family": "mujoco", "machine": "arm", "category": category}
    runs = {"passes": 2, "trajectories": ["move"] * 3}
    return {**head, **runs, "hidden": list(hidden), "changed": list(changed)}


DRAG, FAINT = truth("single", hides("drag", [2])), truth("single", hides("drag", [2], 0.003))
DENT = truth("outside", hides("dent", [1], 0.02, False))
SMALL_DENT = truth("outside", hides("dent", [1], 0.009, False))
TILT = truth("single", {**hides("tilt", [1, 2]), "accept": ["tilt", "gravity."]})
SEEN_ON = truth(
    "single", {**hides("drag", [1, 2]), "observable_per_axis": [0.002, 0.02, 0.02, 0.0]}
)
FAINT_ON = truth(
    "single", {**hides("drag", [1, 2], 0.003), "observable_per_axis": [0.001, 0.003, 0.0, 0.0]}
)
TWO = truth("pair", hides("drag", [2]), hides("bend", [4]))
HEAVY = truth("changed", changed=[{"kind": "mass", "accept": ["link[2]."]}])
LIGHT = truth("changed", changed=[{"kind": "mass", "accept": ["link[2]."], "observable": 0.003}])
LOAD = truth("payload", changed=[{"kind": "payload", "accept": ["payload"], "announced": True}])
NONE, UNKNOWN, DUMB = said("none"), said("unknown"), said("cannot tell")


@pytest.mark.parametrize(
    ("hidden", "answer", "outcome"),
    [
        (truth("nothing"), NONE, "silent"),
        (truth("nothing"), said("changed", changed=["o[1]"]), "silent"),
        (truth("nothing"), UNKNOWN, "unknown"),
        (truth("nothing"), said("named", effect("drag", [1])), "false_alarm"),
        (LOAD, NONE, "silent"),
        (LOAD, said("named", effect("drag", [1])), "false_alarm"),
        (DRAG, said("named", effect("drag", [2])), "right"),
        (DRAG, said("named", effect("drag_too", [2])), "right"),
        (DRAG, said("ambiguous", effect("drag", [2], "drag_too")), "right"),
        (DRAG, said("named", effect("drag", [2, 3])), "right_name_wrong_axes"),
        (DRAG, said("named", effect("drag", [3])), "right_name_wrong_axes"),
        (SEEN_ON, said("named", effect("drag", [1, 2])), "right"),
        (SEEN_ON, said("named", effect("drag", [2])), "right"),
        (SEEN_ON, said("named", effect("drag", [1])), "right_name_wrong_axes"),
        (SEEN_ON, said("named", effect("drag", [2, 3])), "right_name_wrong_axes"),
        (FAINT_ON, said("named", effect("drag", [2])), "right"),
        (FAINT_ON, said("named", effect("drag", [1])), "right_name_wrong_axes"),
        (DRAG, said("ambiguous", effect("bend", [2], "drag")), "ambiguous"),
        (DRAG, said("ambiguous", effect("bend", [2], "a", "b", "drag")), "wrong"),
        (DRAG, said("named", effect("bend", [2])), "wrong"),
        (DRAG, said("named", effect("drag", [2]), effect("bend", [2])), "wrong"),
        (TILT, said("named", effect("tilt", [1, 2])), "right"),
        (TILT, said("changed", changed=["gravity.x"]), "right"),
        (TILT, said("changed", changed=["gravity"]), "missed"),
        (TILT, said("named", effect("drag", [1]), changed=["gravity.x"]), "wrong"),
        (DRAG, NONE, "missed"),
        (DRAG, said("changed", changed=["o[1]"]), "missed"),
        (DRAG, DUMB, "cannot_tell"),
        (DRAG, UNKNOWN, "unknown"),
        (FAINT, NONE, "silent"),
        (FAINT, DUMB, "silent"),
        (FAINT, said("named", effect("bend", [2])), "wrong"),
        (DENT, UNKNOWN, "detected"),
        (DENT, NONE, "missed"),
        (DENT, said("changed", changed=["o[1]"]), "missed"),
        (DENT, DUMB, "cannot_tell"),
        (DENT, said("named", effect("drag", [1])), "wrong"),
        (SMALL_DENT, NONE, "silent"),
        (TWO, said("named", effect("drag", [2]), effect("bend", [4])), "all"),
        (TWO, said("ambiguous", effect("drag", [2], "x"), effect("bend", [4])), "all"),
        (TWO, said("named", effect("bend", [4])), "some"),
        (TWO, said("named", effect("bend", [4]), effect("x", [1])), "some+wrong"),
        (TWO, said("named", effect("x", [1])), "none+wrong"),
        (TWO, said("named", effect("drag", [2]), effect("bend", [3, 4])), "some"),
        (TWO, NONE, "none"),
        (TWO, UNKNOWN, "unknown"),
        (HEAVY, said("changed", changed=["link[2].m"]), "right"),
        (HEAVY, said("changed", changed=["link[1].m"]), "wrong"),
        (HEAVY, said("named", effect("drag", [2]), changed=["link[2].m"]), "wrong"),
        (HEAVY, NONE, "missed"),
        (HEAVY, UNKNOWN, "unknown"),
        (HEAVY, DUMB, "cannot_tell"),
        (LIGHT, NONE, "silent"),
        (LIGHT, said("changed", changed=["link[1].m"]), "wrong"),
    ],
)
def test_outcome_of_an_answer(hidden: Data, answer: Data, outcome: str) -> None:
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
def test_an_answer_of_another_form_is_refused(answer: Data) -> None:
    with pytest.raises(ValueError, match="answer: "):
        score(answer, DRAG)


def rows(outcomes: Sequence[Outcome]) -> dict[tuple[str, str], tuple[int, int]]:
    """Claims by what is hidden and what is said."""
    return {(c.kind, c.ending): (c.hits, c.n) for c in tables.claims(outcomes)}


def test_intervals_are_compared_with_the_true_values() -> None:
    narrow = score(said("named", effect("drag", [2], F=(0.4, 0.6))), DRAG)
    wide = score(said("named", effect("drag", [2], F=(0.6, 0.7))), DRAG)
    other = score(said("named", effect("bend", [2], F=(0.4, 0.6))), DRAG)
    assert narrow.covered == {"drag.F[2]": True}
    assert wide.covered == {"drag.F[2]": False}
    assert wide.errors["drag.F[2]"] == pytest.approx(0.15 / (0.1 / 2 / 1.959964))
    assert other.covered == {}
    assert rows([narrow, wide, other])["95 % intervals", "hold the true value"] == (1, 2)


def test_calibration_sets_the_confidence_beside_what_was_right() -> None:
    right = score(said("named", effect("drag", [2])), DRAG)
    wrong = score(said("named", effect("bend", [2])), DRAG)
    sure = [replace(right, confidence=0.95), replace(wrong, confidence=0.95)]
    table = rows([*sure, replace(wrong, confidence=0.3), replace(right, confidence=1.0), right])
    assert table["confidence", "right where 20 to 40 % is printed"] == (0, 1)
    assert table["confidence", "right where 80 to 100 % is printed"] == (2, 3)
    assert table["confidence", "right where 0 to 20 % is printed"] == (0, 0)


SEEN = "one effect, at least 0.4% of torque RMS observable"
CLEAR = "outside the library, at least 1% observable"
BOTH = "two effects, both at least 1%"


def test_table_counts_by_what_is_hidden_and_by_size() -> None:
    named = said("named", effect("drag", [2]))
    elsewhere = said("named", effect("drag", [3]))
    wrong = said("named", effect("bend", [2]))
    outcomes = [score(a, DRAG) for a in (named, elsewhere, wrong, NONE, UNKNOWN, DUMB)]
    outcomes += [score(NONE, FAINT), score(wrong, FAINT), score(NONE, SMALL_DENT)]
    outcomes += [score(UNKNOWN, DENT), score(wrong, DENT), score(None, DENT, "failed")]
    outcomes += [score(named, TWO), score(NONE, HEAVY), score(NONE, LOAD), score(wrong, LOAD)]
    table = rows(outcomes)
    assert table[SEEN, "right, alone"] == (1, 6)
    assert table[SEEN, "wrong"] == (1, 6)
    assert table[SEEN, "missed"] == (2, 6)
    assert table[SEEN, "of the right names, right axes"] == (1, 2)
    assert table["one effect, fainter", "wrong"] == (1, 2)
    assert table[CLEAR, "`unknown`"] == (1, 3)
    assert table[CLEAR, "a name"] == (1, 3)
    assert table[BOTH, "both"] == (0, 1)
    assert table[BOTH, "one of them"] == (1, 1)
    assert table["changed parameters, payload between runs", "right"] == (0, 1)
    assert table["nothing hidden", "silent"] == (1, 2)
    assert table["nothing hidden", "an effect named"] == (1, 2)
    assert "1 of 6 (95 % interval 3 to 56 %)" in tables.text(outcomes)


def test_waves_are_counted_where_another_trajectory_can_show_them() -> None:
    """That nothing is named where there is none is right; an invented delay never is."""
    found = replace(score(NONE, DRAG), category="plain", checks={"order [1]": True})
    hushed = replace(found, alone=True, checks={"order [1]": False, "no delay": False})
    table = rows([found, hushed])
    assert table["plain axes", "order of the cogging exact"] == (1, 1)
    assert table["plain axes", "a delay invented"] == (1, 1)


def test_families_stand_side_by_side() -> None:
    one = score(NONE, DRAG)
    head, *_, last = tables.text([one, replace(one, family="other")]).splitlines()
    assert head == "| hidden | said | wanted | mujoco | other |"
    assert last.startswith("| physics |")

"""The scorer and its tables."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest

from results.shares import share, wilson
from studies import hidden_effects, tables
from studies.score import Score, beside, score

Found = dict[str, Any]


def truth(tmp_path: Path, category: str, *hidden: tuple[str, list[int]], kind: str = "") -> Path:
    """A sealed file."""
    rows = [
        {"id": id, "axes": axes, "size": 0.01, "observable": 0.006, "wanted": 0.01}
        for id, axes in hidden
    ]
    changed = [{"kind": kind, "parameter": "end_effector.m"}] if kind else []
    path = tmp_path / "truth.json"
    row = {"seed": 1, "category": category, "closed": False, "hidden": rows, "changed": changed}
    path.write_text(json.dumps(row))
    return path


def effect(id: str, axes: Sequence[int] = (), *rivals: str) -> Found:
    return {"id": id, "axes": list(axes), "rivals": list(rivals)}


def said(verdict: str, *effects: Found, changed: Sequence[str] = ()) -> Found:
    return {
        "verdict": verdict,
        "effects": list(effects),
        "changed": [{"parameter": name} for name in changed],
        "gap": {"before": 0.05, "after": 0.014, "floor": 0.01},
    }


DRAG, BEND = ("quadratic_drag", [2]), ("cubic_stiffness", [4])
ALL = ("gravity_tilt", [1, 2, 3, 4, 5, 6])


@pytest.mark.parametrize(
    ("category", "hidden", "found", "outcome"),
    [
        ("nothing", (), said("none"), "silent"),
        ("nothing", (), said("changed", changed=["actuator[1].k"]), "silent"),
        ("nothing", (), said("unknown"), "unknown"),
        ("nothing", (), said("named", effect("quadratic_drag", [2])), "false_alarm"),
        ("nothing", (), said("set", effect("quadratic_drag", [2], "time_delay")), "false_alarm"),
        ("single", (DRAG,), said("named", effect("quadratic_drag", [2])), "alone"),
        ("single", (DRAG,), said("named", effect("quadratic_drag", [3])), "wrong"),
        ("single", (DRAG,), said("named", effect("quadratic_drag", [2, 5])), "joints"),
        ("single", (DRAG,), said("named", effect("quadratic_drag")), "joints"),
        ("single", (ALL,), said("named", effect("gravity_tilt")), "alone"),
        ("single", (ALL,), said("named", effect("gravity_tilt", [1])), "joints"),
        ("single", (DRAG,), said("set", effect("cubic_stiffness", [2], "quadratic_drag")), "set"),
        ("single", (DRAG,), said("set", effect("a", [2], "b", "c", "quadratic_drag")), "wrong"),
        ("single", (DRAG,), said("named", effect("cubic_stiffness", [2])), "wrong"),
        (
            "single",
            (DRAG,),
            said("named", effect("quadratic_drag", [2]), effect("cubic_stiffness", [2])),
            "wrong",
        ),
        ("single", (DRAG,), said("none"), "missed"),
        ("single", (DRAG,), said("unknown"), "missed"),
        ("outside", (("backlash", [1]),), said("unknown"), "detected"),
        ("outside", (("backlash", [1]),), said("none"), "unnoticed"),
        ("outside", (("backlash", [1]),), said("changed", changed=["actuator[1].d"]), "unnoticed"),
        ("outside", (("backlash", [1]),), said("named", effect("quadratic_drag", [1])), "wrong"),
        (
            "pair",
            (DRAG, BEND),
            said("named", effect("quadratic_drag", [2]), effect("cubic_stiffness", [4])),
            "alone",
        ),
        (
            "pair",
            (DRAG, BEND),
            said("set", effect("quadratic_drag", [2], "d"), effect("cubic_stiffness", [4])),
            "set",
        ),
        (
            "pair",
            (DRAG, BEND),
            said("named", effect("quadratic_drag", [2]), effect("cubic_stiffness", [3, 4])),
            "joints",
        ),
        ("pair", (DRAG, BEND), said("named", effect("cubic_stiffness", [4])), "some"),
        ("pair", (DRAG, BEND), said("named", effect("time_delay", [4])), "wrong"),
    ],
)
def test_outcome_of_a_verdict(
    tmp_path: Path,
    category: str,
    hidden: tuple[tuple[str, list[int]], ...],
    found: Found,
    outcome: str,
) -> None:
    judged = score(found, truth(tmp_path, category, *hidden))
    assert judged.outcome == outcome
    assert judged.closed_gap == pytest.approx(0.9)


@pytest.mark.parametrize(
    ("found", "outcome"),
    [
        (said("changed", changed=["end_effector.m"]), "right"),
        (said("changed", changed=["actuator[2].o", "end_effector.m"]), "right"),
        (said("changed", changed=["actuator[2].o"]), "wrong"),
        (said("named", effect("quadratic_drag", [2])), "wrong"),
        (said("named", effect("payload")), "right"),
        (said("none"), "missed"),
    ],
)
def test_outcome_of_a_changed_parameter(tmp_path: Path, found: Found, outcome: str) -> None:
    assert score(found, truth(tmp_path, "changed", kind="payload")).outcome == outcome


@pytest.mark.parametrize(
    ("kind", "name"),
    [
        ("offset", "actuator[4].o"),
        ("damping", "actuator[1].d"),
        ("stiffness", "flexure.k_u3"),
        ("payload", "end_effector.m"),
    ],
)
def test_changed_parameters_are_known_by_the_names_that_the_diagnosis_gives(
    tmp_path: Path, kind: str, name: str
) -> None:
    def outcome(told: str) -> str:
        found = said("changed", changed=[told])
        return score(found, truth(tmp_path, "changed", kind=kind)).outcome

    assert outcome(name) == "right"
    assert outcome("upper.J_xx") == "wrong"


@pytest.mark.parametrize(
    "found",
    [
        {"verdict": "sure", "effects": [], "changed": []},
        {"verdict": "named", "effects": [], "changed": []},
        {"verdict": "none", "effects": None, "changed": []},
        {"verdict": "named", "effects": [{"axes": [1]}], "changed": []},
    ],
)
def test_score_refuses_what_is_no_verdict(tmp_path: Path, found: Found) -> None:
    with pytest.raises(ValueError, match=r"verdict|effects"):
        score(found, truth(tmp_path, "nothing"))


def test_gap_without_a_gap_has_no_reduction(tmp_path: Path) -> None:
    found = said("none") | {"gap": {"before": 0.01, "after": 0.01, "floor": 0.01}}
    assert score(found, truth(tmp_path, "nothing")).closed_gap is None


@pytest.mark.parametrize(("floor", "closed"), [(0.0103, 1.0), (0.02, 0.9), (0.005, 0.9)])
def test_gap_of_an_effect_is_what_it_adds_to_the_same_runs_without_it(
    tmp_path: Path, floor: float, closed: float
) -> None:
    """Unless the floors differ: then only the gap's own floor is a measure of it."""
    twin = said("none") | {"gap": {"before": 0.014, "after": 0.014, "floor": floor}}
    found = said("named", effect("quadratic_drag", [2]))
    judged = beside(score(found, truth(tmp_path, "single", DRAG)), twin)
    assert judged.closed_gap == pytest.approx(0.9)
    assert judged.closed_effect == pytest.approx(closed)


def test_wilson_is_the_textbooks() -> None:
    """Newcombe (1998), table I: 81 of 263 and 0 of 20."""
    assert wilson(81, 263) == pytest.approx((0.2553, 0.3662), abs=5e-5)
    assert wilson(0, 20) == pytest.approx((0.0, 0.1611), abs=5e-5)
    assert wilson(0, 0) == (0.0, 1.0)
    assert share(0, 17) == "0 of 17 (95 % interval 0 to 18 %)"
    assert share(0, 0) == "no case"


def judged(category: str, outcome: str, named: tuple[str, ...] = (), seen: float = 0.006) -> Score:
    hidden = ("quadratic_drag",) if category == "single" else ()
    sizes = (seen,) if hidden else ()
    return Score(1, category, False, hidden, sizes, sizes, "named", named, outcome, 0.95)


def test_tables_count_what_is_there() -> None:
    scores = [judged("nothing", "silent")] * 3 + [judged("nothing", "false_alarm", ("time_delay",))]
    scores += [judged("single", "alone", ("quadratic_drag",))] * 2
    scores += [judged("single", "wrong", ("time_delay",)), judged("single", "missed", (), 0.001)]
    scores += [judged("outside", "unnoticed")] * 4 + [judged("outside", "detected")]
    (alarms,) = (c for c in tables.claims(scores) if c.ending == "an effect named" and c.n == 4)
    assert (alarms.kind, alarms.hits) == ("nothing hidden", 1)
    kinds = {c.kind: c for c in tables.claims(scores) if "alone" in c.ending and c.n}
    assert [(c.hits, c.n) for c in kinds.values()] == [(2, 3), (0, 1)]
    outside = [c for c in tables.claims(scores) if c.kind == "outside the library"]
    assert [(c.hits, c.n) for c in outside] == [(1, 5), (4, 5), (0, 5)]
    columns, matrix = tables.confusion(scores)
    counts = {truth: dict(zip(columns, row, strict=True)) for truth, row in matrix}
    assert counts["quadratic_drag"]["quadratic_drag"] == 2
    assert counts["(nothing)"]["time_delay"] == 1
    assert "quadratic_drag" in tables.text(scores)


draw_of: Callable[..., Any] = hidden_effects.draw

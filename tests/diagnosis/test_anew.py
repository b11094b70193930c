"""What was accepted is revised beside what is found later."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flexhex.diagnosis.selection import anew, search, select
from flexhex.diagnosis.selection.choose import Accepted
from flexhex.diagnosis.selection.criteria import USUAL
from flexhex.diagnosis.selection.hypothesis import EffectHypothesis
from flexhex.diagnosis.selection.scores import Score
from tests.diagnosis.test_search import orders, several
from tests.diagnosis.test_selection import RMS, chosen


@several
def test_first_of_two_waves_that_are_close_is_revised(tmp_path: Path) -> None:
    """Alone it stands in for both, with an order between them."""
    selection = chosen(
        tmp_path, lambda q, v, a: 0.01 * RMS * (np.sin(18.0 * q) + np.sin(24.0 * q + 1.0))
    )
    np.testing.assert_allclose(orders(selection), (18.0, 24.0), atol=0.7)


@several
def test_shapes_move_with_what_is_found_later(tmp_path: Path) -> None:
    """The first wave, much larger than the others, was fitted while these and friction were there;
    they in turn while its order was a little off."""
    selection = chosen(
        tmp_path,
        lambda q, v, a: (
            (
                np.sin(29.0 * q)
                + 0.3 * np.sin(58.0 * q + 1.0)
                + 0.2 * np.sin(87.0 * q + 2.0)
                + 0.1 * np.tanh(v / 0.02)
            )
            * RMS
        ),
    )
    np.testing.assert_allclose(orders(selection), (29.0, 58.0, 87.0), atol=0.02)


@pytest.mark.parametrize(
    ("now", "axis", "chosen_anew"),
    [(100.0, 0, []), (300.0, 0, []), (90.0, 0, [0]), (90.0, 1, []), (90.0, None, [0])],
)
def test_earlier_effect_is_chosen_anew_where_the_latest_took_from_it(
    now: float, axis: int | None, chosen_anew: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    """It may have stood in for two; what gains as much as ever has not, nor what does not feel the
    latest one. What the whole machine has is felt by all."""
    monkeypatch.setattr(search, "bars_of", lambda *_: None)
    monkeypatch.setattr(search, "noisy", lambda _: set())
    monkeypatch.setattr(anew, "together", lambda *_: now)
    monkeypatch.setattr(anew, "reshape", lambda *_: None)
    moments: Any = SimpleNamespace(without=lambda *_: None)
    hypotheses: Any = SimpleNamespace(rows=SimpleNamespace(n=2), moments=moments)
    effects: list[Any] = [
        SimpleNamespace(id=name, axis=own, exact=False)
        for name, own in zip("ab", (0, axis), strict=True)
    ]
    result = search.Search(hypotheses, USUAL)
    for effect in effects:
        result.accepted.append(Accepted(Score(effect, 100.0, np.zeros(1), 0.1), (), 1))
        result.terms.append(("its columns",))  # type: ignore[arg-type]
    places = list[int]()
    monkeypatch.setattr(anew, "choose_anew", lambda _, place: places.append(place))
    anew.revise(result, effects[1])
    assert places == chosen_anew


@pytest.mark.parametrize(("rivals", "chosen_anew"), [("fuller", [2, 0]), ("other", []), ("", [])])
def test_all_are_chosen_anew_where_a_fuller_form_is_a_rival(
    rivals: str, chosen_anew: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The last one first; a parameter has no shape."""
    effect, score = SimpleNamespace(axis=0), lambda: Score(effect, 100.0, np.zeros(1), 0.1)  # type: ignore[arg-type]
    fuller, other, plain = score(), score(), Accepted(score(), (), 1)
    listed = {"fuller": (fuller,), "other": (other,), "": ()}[rivals]
    places = list[int]()
    monkeypatch.setattr(anew, "choose_anew", lambda _, place: places.append(place))
    found: Any = SimpleNamespace(
        accepted=[Accepted(score(), listed, 1, (fuller,)), plain, plain],
        terms=[("columns",), (), ("columns",)],
    )
    anew.review(found)
    assert places == chosen_anew


@pytest.mark.parametrize("then", [5.0, 2.0], ids=["more", "less"])
def test_shape_moves_only_to_more_evidence(then: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """Else the model is the one before, to the last term."""
    monkeypatch.setattr(search, "bars_of", lambda *_: None)
    monkeypatch.setattr(search, "noisy", lambda _: set())
    effect, latest = (SimpleNamespace(id=name, axis=0, shapes=({"s": 1.0},)) for name in "ab")
    other: Any = SimpleNamespace(id="a", axis=0, shapes=({"s": 2.0},))
    moments: Any = SimpleNamespace(without=lambda *_: "without")
    rows: Any = SimpleNamespace(n=1)
    hypotheses: Any = SimpleNamespace(rows=rows, moments=moments, shaped=lambda *_: None)
    asked = search.Search(hypotheses, USUAL)
    for each in (effect, latest):
        asked.accepted.append(Accepted(Score(each, 9.0, np.zeros(1), 0.1), (), 1))  # type: ignore[arg-type]
        asked.terms.append((each.id,))
    before, accepted, moved = asked.accepted[0], list[Any](), replace(asked.accepted[0].score)
    fit: Any = SimpleNamespace(evidence=np.array([3.0, then]))
    for name, value in {
        "reshaped": {0: other},
        "beside_lookalike": None,
        "tried": {None: fit},
        "with_shape": moved,
    }.items():
        monkeypatch.setattr(anew, name, lambda *_, value=value: value)
    monkeypatch.setattr(anew, "EffectHypothesis", SimpleNamespace)
    monkeypatch.setattr(Score, "effect", property(lambda _: ("a", 0, {})))
    monkeypatch.setattr(asked, "determined", lambda _: True)
    monkeypatch.setattr(asked, "accept", lambda one, place: accepted.append((one.score, place)))
    anew.reshape(asked, {0})
    assert accepted == ([(moved, 0)] if then > 3.0 else [])
    if then < 3.0:
        assert asked.moments is moments
        assert asked.accepted[0] is before
        assert asked.terms == [("a",), ("b",)]


@pytest.mark.parametrize("case", ["renamed", "later", "sure"])
def test_effect_by_another_name_is_asked_by_its_place(
    case: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What came in its place later is none that the search knows, and may imitate anything."""
    effect = object.__new__(EffectHypothesis)
    vars(effect).update(id="a", axis=0)
    one, other = (Accepted(Score(effect, 9.0, np.zeros(1), 0.1), (), 1) for _ in range(2))
    places = list[int]()

    def surely(_: object, __: object, place: int, ___: object) -> bool:
        places.append(place)
        return case == "sure"

    monkeypatch.setattr(select, "surely_beside", surely)
    selection: Any = object.__new__(select.Selection)
    vars(selection).update(
        accepted=(other, one), search=None, imitated=(SimpleNamespace(beside=None),)
    )
    asked = replace(one) if case == "later" else one
    assert selection.imitates(asked) == (case != "sure")
    assert places == ([] if case == "later" else [1])

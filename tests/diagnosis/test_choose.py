"""Which of several hypotheses gets the name, on one axis and on all."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flexhex.diagnosis.selection.bars import Bars
from flexhex.diagnosis.selection.choose import Accepted, chosen, one_cause, simplest
from flexhex.diagnosis.selection.criteria import USUAL
from flexhex.diagnosis.selection.hypothesis import EffectHypothesis
from flexhex.diagnosis.selection.parts import with_wholes
from flexhex.diagnosis.selection.scores import Score


def scored_as(name: str, axis: int, freedom: int) -> Score:
    of = {"freedom": freedom, "extends": "", "choices": 1}
    hypothesis: Any = SimpleNamespace(id=name, axis=axis, **of)
    return Score(hypothesis, 60.0, np.zeros(2), 0.01)


@pytest.mark.parametrize(("there", "name"), [(False, "viscous"), (True, "drag")])
def test_what_an_axis_has_already_is_no_name_for_something_beside_it(
    there: bool, name: str
) -> None:
    """Viscous friction on another axis is a reason to call it so here, unless it is here, too."""
    elsewhere = Accepted(scored_as("viscous", 1, 1), (), 1)
    here = [Accepted(scored_as("viscous", 0, 1), (), 2)] if there else []
    drag = Accepted(scored_as("drag", 0, 1), (scored_as("viscous", 0, 1),), 3)
    assert one_cause([elsewhere, *here, drag])[-1].score.hypothesis.id == name


def test_fuller_form_of_an_effect_is_taken_where_another_axis_needs_it() -> None:
    """Coulomb friction on one axis and Stribeck's on another is one cause."""
    coulomb, fuller = scored_as("coulomb", 0, 1), scored_as("stribeck", 0, 3)
    other = Accepted(scored_as("stribeck", 1, 3), (), 1)
    alone = Accepted(coulomb, (), 2, (fuller,))
    assert [a.score.hypothesis.id for a in one_cause([alone])] == ["coulomb"]
    assert [a.score.hypothesis.id for a in one_cause([other, alone])] == ["stribeck"] * 2


def test_what_a_trajectory_speaks_against_is_no_simpler_name() -> None:
    """It gains more, by one trajectory alone."""
    best = replace(scored_as("stribeck", 0, 3), whole=500.0, without=np.array([250.0, 250.0]))
    other = replace(scored_as("lag", 0, 1), whole=2000.0, without=np.array([2600.0, 100.0]))
    assert other.gain > best.gain
    bars, both = Bars(5.0, 3.0), [other, best]
    accepted = chosen(lambda score: 0.0, (), both, bars, 1, USUAL, lambda score: score)
    assert accepted is not None
    assert (accepted.score, accepted.rivals) == (best, ())


@pytest.mark.parametrize(
    ("axis", "gain", "there"), [(0, 1695.0, False), (0, 1705.0, True), (1, 700.0, True)]
)
def test_what_explains_no_more_than_something_faint_is_not_there(
    axis: int, gain: float, there: bool
) -> None:
    """A small eccentricity looks like a little more of a wave of the torque."""
    half, less = USUAL.smallest_effect / 2, np.full(2, 850.0)
    faint = replace(scored_as("eccentricity", 0, 2), whole=1700.0, without=less, size=half)
    less = np.full(2, gain / 2)
    wave = replace(scored_as("wave", axis, 2), whole=gain, without=less, size=4 * half)
    both = sorted([faint, wave], key=lambda score: -score.gain)
    accepted = chosen(lambda score: 0.0, (), both, Bars(5.0, 3.0), 1, USUAL, lambda score: score)
    assert (accepted is not None) == there
    assert accepted is None or accepted.score is wave


@pytest.mark.parametrize("fuller", ["extends", "limit"])
@pytest.mark.parametrize(
    ("better", "size", "rivals"),
    [(1.0, 0.1, []), (10.0, 0.1, ["stribeck"]), (10.0, 0.01, [])],
)
def test_fuller_form_is_a_rival_where_what_it_adds_is_worth_a_name(
    better: float, size: float, rivals: list[str], fuller: str
) -> None:
    """Within the error of the form the simpler one comes first; that it is no more nobody knows,
    unless the fuller one predicts no better than by chance, or by next to no torque."""
    scores = []
    for name, gain, freedom in (("stribeck", 2000.0 + better, 3), ("coulomb", 2000.0, 1)):
        of = {"extends": "", fuller: "coulomb" if name == "stribeck" else ""}
        effect = EffectHypothesis(
            name, 0, (), dict, (0,), np.zeros(1), np.ones(1), freedom, exact=False, most=1, **of
        )
        scores.append(Score(effect, gain / 2, np.zeros(2), size))
    accepted = simplest(scores[0], scores, 1, USUAL)
    assert accepted.score.hypothesis.id == "coulomb"
    assert [score.hypothesis.id for score in accepted.rivals] == rivals
    assert [score.hypothesis.id for score in accepted.fuller] == ["stribeck"]


@pytest.mark.parametrize(
    ("better", "second", "rivals"),
    [(100.0, False, ["stribeck"]), (1.0, False, []), (100.0, True, [])],
)
def test_whole_is_a_rival_of_a_part_that_stands_alone(
    better: float, second: bool, rivals: list[str]
) -> None:
    """A part takes the place of the whole where a second effect makes up for the difference; that
    may vanish, as the search goes on."""
    part = scored_as("coulomb", 0, 1)
    whole = replace(scored_as("stribeck", 0, 3), whole=part.whole + better)
    beside = Accepted(scored_as("drag", 0 if second else 1, 1), (), 2)
    first, _ = with_wholes([Accepted(part, (), 1, (whole,)), beside], USUAL)
    assert [score.hypothesis.id for score in first.rivals] == rivals


def test_same_effect_with_another_shape_is_no_name_of_its_own() -> None:
    """It may be a rival, with more numbers."""
    first, same = scored_as("ripple", 0, 2), scored_as("ripple", 0, 3)
    (kept,) = one_cause([Accepted(first, (same, scored_as("drag", 0, 3)), 1)])
    assert kept.score is first
    assert [rival.hypothesis.id for rival in kept.rivals] == ["drag"]

"""Something without a name beside what was accepted on an axis, and in its place."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flexhex.diagnosis.selection.choose import as_good
from flexhex.diagnosis.selection.evidence import evidence_of, together
from flexhex.diagnosis.selection.generic_scores import Whole, generic_score
from flexhex.diagnosis.selection.moments import Term
from flexhex.diagnosis.selection.scores import Score
from flexhex.diagnosis.selection.search import Search
from flexhex.diagnosis.selection.unnamed import NamelessHypothesis


@dataclass(frozen=True)
class Imitated:
    """Something without a name on an axis, beside all that was accepted; instead: in the place of
    all effects there, or of those at some `places` of them, where it predicts better than these;
    placed: where those stand that are functions of the angle; angle: relative RMS of another one
    beside all, where there are any; beyond: relative RMS of what repeats and is none of it."""

    beside: Score
    instead: Score | None = None
    places: tuple[int, ...] = ()
    placed: tuple[int, ...] = ()
    angle: float = 0.0
    beyond: float = np.inf


def imitated(search: Search, axis: int) -> Imitated:
    """Whether effects of an axis only imitate something without a name: all together, or those
    alone that go with the angle."""
    unnamed = search.hypotheses.generic(axis)
    beside = generic_score(search.moments, unnamed)
    own, with_angle = search.own(axis), search.hypotheses.with_angle
    if not own:
        return Imitated(beside)
    every, whole = tuple(range(len(own))), Whole.of(search.moments, unnamed[-1])
    beyond = whole.beyond(axis)
    placed = tuple(k for k in every if with_angle(own[k][0].hypothesis.id))
    for places in (every, placed):
        instead = _better(search, unnamed, [own[k] for k in places], beside)
        if instead is not None:
            return Imitated(beside, instead, places, beyond=beyond)
    angle = 0.0
    if placed and beside.gain > search.bars.first:
        angle = whole.part(next(each for each in unnamed if each.columns.id == "angle"))
    return Imitated(beside, placed=placed, angle=angle, beyond=beyond)


def _better(
    search: Search,
    unnamed: Sequence[NamelessHypothesis],
    effects: Sequence[tuple[Score, Sequence[Term]]],
    beside: Score,
) -> Score | None:
    """Something without a name in the place of these effects, if it predicts better than they do
    with the errors of their form and with something without a name beside them. All runs together
    must say so, too: what learns little from other trajectories has more to gain from one."""
    if not effects:
        return None
    other, margins = _margins(search, unnamed, effects, beside)
    return None if any(as_good(m, 0.0, 0.0, search.criteria) for m in margins) else other


def surely_beside(search: Search, axis: int, place: int, beside: Score) -> bool:
    """Whether the effect at a place of an axis predicts more than chance with something without a
    name beside it, too: what only imitates that does not."""
    unnamed, own = search.hypotheses.generic(axis), search.own(axis)[place]
    _, margins = _margins(search, unnamed, [own], beside)
    return min(margins) > search.bars.first * own[0].doubt


def _margins(
    search: Search,
    unnamed: Sequence[NamelessHypothesis],
    effects: Sequence[tuple[Score, Sequence[Term]]],
    beside: Score,
) -> tuple[Score, tuple[float, float]]:
    """Something without a name in the place of these effects, and what they gain with something
    without a name beside them more than that: on left-out folds, and of all runs together [nats].
    """
    moments = search.moments
    terms = [term for _, both in effects for term in both]
    other = generic_score(moments.without(*terms), unnamed)
    price = sum(score.price for score, _ in effects)
    gain = together(moments, terms) + max(beside.gain, 0.0) - price
    whole = evidence_of(moments, terms) + max(beside.whole, 0.0) - price
    return other, (gain - other.gain, whole - other.whole)

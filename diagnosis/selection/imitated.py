"""Something without a name beside what was accepted on an axis, and in its place."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import log

import numpy as np

from flexhex.diagnosis.selection.choose import as_good
from flexhex.diagnosis.selection.evidence import evidence_of, together
from flexhex.diagnosis.selection.generic_scores import Whole, generic_score, generic_term
from flexhex.diagnosis.selection.moments import Moments, Term
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
    """Something without a name in the place of these effects, if it has more evidence than they do
    with the errors of their form. Left-out folds may not deny it: where rows are many they hardly
    tell how many numbers it takes, but they do tell what one fold has alone."""
    if not effects:
        return None
    other, (gain, whole) = _margins(search, unnamed, effects, beside)
    keeps = as_good(whole, 0.0, 0.0, search.criteria) or gain > log(search.criteria.odds)
    return None if keeps else other


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
    """Something without a name in the place of these effects, and what they gain more than that: on
    left-out folds, and of all runs together [nats]. Beside either of them may be something else
    without a name, as errors of the forms of others are."""
    moments = search.moments
    terms = [term for _, both in effects for term in both]
    plain = moments.without(*terms)
    other = generic_score(plain, unnamed)
    ways = [of_two_kinds(of, unnamed, first) for of, first in ((moments, beside), (plain, other))]
    (gain, whole), instead = ways
    gain += together(moments, terms)
    whole += evidence_of(moments, terms)
    # a shape that was fitted to a fold, too, predicts it too well: by all folds about one nat
    gain -= sum(score.fitted for score, _ in effects)
    whole -= sum(score.price for score, _ in effects)
    return other, (gain - instead[0], whole - instead[1])


def of_two_kinds(
    moments: Moments, unnamed: Sequence[NamelessHypothesis], first: Score
) -> tuple[float, float]:
    """What two kinds of something without a name gain beside a model, the first of which is known:
    on left-out folds, and of all runs together [nats]. What hardly repeats of the first may leave
    products between passes that only noise can make: the second is not asked for then."""
    kind = next(each for each in unnamed if each.columns.id == first.hypothesis.id)
    longer, scores = moments.extended(generic_term(moments, kind)), [first]
    if all(longer.fit(left).sure for left in (None, *longer.rows.folds)):
        scores.append(generic_score(longer, unnamed))
    # evidence for what predicts nothing is none
    there = [score for score in scores if score.gain > 0]
    return sum(score.gain for score in there), sum(max(score.whole, 0.0) for score in there)

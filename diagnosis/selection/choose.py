"""What is accepted of the hypotheses of a round: the simplest of those that predict best."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from math import log

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.selection.bars import (
    Bars,
    Plainly,
    beyond_chance,
    form_error,
    repeated,
    shown,
)
from flexhex.diagnosis.selection.changed import Axis, ChangedParameter
from flexhex.diagnosis.selection.changes import change_scores
from flexhex.diagnosis.selection.criteria import Criteria
from flexhex.diagnosis.selection.evidence import Tried, evidences
from flexhex.diagnosis.selection.hypotheses import Hypotheses
from flexhex.diagnosis.selection.hypothesis import EffectHypothesis
from flexhex.diagnosis.selection.lookalike import beside_lookalike
from flexhex.diagnosis.selection.moments import Left, Moments
from flexhex.diagnosis.selection.scores import (
    Score,
    effect_score,
)
from flexhex.diagnosis.selection.survey import surveyed

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Accepted:
    """A hypothesis that was chosen in a round (from 1), and those that predict equally well;
    fuller: effects among these that it is a part of; inexact: how large the errors of its form are
    beside all that was accepted, relative to `form_error`. named: whether it gets a name, or is in
    the fit alone; faint: that is for the sake of others' values."""

    score: Score
    rivals: tuple[Score, ...]
    round: int
    fuller: tuple[Score, ...] = ()
    inexact: float = 1.0
    named: bool = True
    faint: bool = False


def chosen(
    least: Callable[[Score], float],
    known: Sequence[Score],
    scores: Sequence[Score],
    bars: Bars,
    number: int,
    criteria: Criteria,
    plainly: Plainly,
) -> Accepted | None:
    """What is accepted of the scores of a round beside those that are known; least: what one must
    gain [nats]. Where the best of an axis is too small for a name, what is larger but explains no
    more is not there."""
    faint = set[Axis]()

    def good(score: Score, criteria: Criteria = criteria) -> bool:
        there = shown(score, criteria, repeated(score, known))
        return there and beyond_chance(score, known, bars, criteria, plainly)

    for score in scores:
        axis = score.hypothesis.axis
        if score.gain <= least(score) or axis in faint:
            continue
        if good(score):
            return simplest(score, scores, number, criteria, good)
        if good(score, replace(criteria, smallest_effect=0.0)):
            faint.add(axis)
    return None


def effect_scores(
    moments: Moments,
    hypotheses: Hypotheses,
    known: Sequence[Score],
    criteria: Criteria,
    axes: Iterable[Axis],
) -> list[Score]:
    """Scores of the most promising effects of each of these axes beside those that are known; what
    is a part of another one can only take its place."""
    scores = list[Score]()
    for axis in axes:
        listed = []
        own = Counter(k.hypothesis.id for k in known if k.hypothesis.axis == axis)
        taken = [k.effect for k in known if k.hypothesis.axis in (axis, None)]
        parts = {k.hypothesis.extends for k in known if k.hypothesis.axis == axis}
        for effect in hypotheses.effects(axis) if own.total() < criteria.most else ():
            part = effect.id in parts or effect.extends in own
            if own[effect.id] < effect.most and not part:
                orders = [k.order for k in known if k.order and k.hypothesis.id == effect.id]
                hidden = hypotheses.anew(moments, effect, repr(taken) if taken else "", orders)
                ways = [effect, *hidden]
                listed.append(max((_fitted(moments, way) for way in ways), key=lambda f: f[0]))
        listed.sort(key=lambda item: -item[0])
        for gain, effect, fits in listed[: criteria.shortlist]:
            if gain > 0:
                error = criteria.error_of(effect.exact)
                beside = beside_lookalike(moments, hypotheses, effect, own)
                scores.append(effect_score(moments, hypotheses, effect, fits, error, beside))
    return scores


def _fitted(
    moments: Moments, effect: EffectHypothesis
) -> tuple[float, EffectHypothesis, dict[Left, Tried]]:
    """What an effect gains on left-out folds, and its fits."""
    fits = surveyed(moments, effect)
    whole, without = evidences(fits, moments.rows.folds)
    return float((whole - without).sum()), effect, fits


def parameter_scores(moments: Moments, hypotheses: Hypotheses, criteria: Criteria) -> list[Score]:
    """Scores of the base parameters that are not free yet."""
    closed = (c for c in hypotheses.changes if not set(c.places) <= set(moments.freed))
    return change_scores(moments, closed, criteria)


def best_first(scores: Iterable[Score]) -> list[Score]:
    """Those that gain anything."""
    return sorted((s for s in scores if s.gain > 0), key=lambda score: -score.gain)


def simplest(
    best: Score,
    scores: Sequence[Score],
    number: int,
    criteria: Criteria,
    good: Callable[[Score], bool] = lambda score: True,
) -> Accepted:
    """The hypothesis with the fewest free numbers of those that are `good` and predict as well as
    the best one on its axis; the others are its rivals, but for those that extend it and hardly
    predict better."""
    axis, error = best.hypothesis.axis, form_error(best, criteria)
    near = [
        score
        for score in scores
        if score is best
        or (
            (score.hypothesis.axis == axis or isinstance(score.hypothesis, ChangedParameter))
            and as_good(score.gain, best.gain, max(error, form_error(score, criteria)), criteria)
            and good(score)
        )
    ]
    first = min(near, key=lambda score: (score.hypothesis.freedom, -score.gain))
    fuller = [s for s in near if first.hypothesis.id in _simpler(s)]
    idle = [s for s in fuller if not _adds(s, first, criteria)]
    rivals = [s for s in near if s is not first and s not in idle]
    return Accepted(first, tuple(rivals), number, tuple(fuller))


def _adds(fuller: Score, first: Score, criteria: Criteria) -> bool:
    """Whether a fuller form predicts better, by a torque that is worth a name."""
    more = fuller.gain - first.gain
    size = fuller.size * max(more / fuller.gain, 0.0) ** 0.5
    return more > log(criteria.odds) and size > criteria.smallest_effect


def _simpler(score: Score) -> tuple[str, ...]:
    """Effects that this one is a fuller form of."""
    own = score.hypothesis
    return (own.extends, own.limit) if isinstance(own, EffectHypothesis) else (own.extends,)


def unrepeated(plain: Moments, known: Sequence[Score]) -> Callable[[Score], float]:
    """Least gain [nats] of an effect where nothing repeats; plain: the model without what feedback
    may answer to noise.

    Nothing but another trajectory speaks for it then. Noise of the angles makes accelerations, and
    so all torques: what goes with these is not named if it explains less than half of all that is
    left beside `plain`, nor beside an effect that is known. Nothing is beside a payload.
    """
    rows = plain.rows
    if rows.pairs.nnz:
        return lambda score: 0.0
    q = plain.fit(None).q
    left = [float(((rows.white_y[i] - plain.white(i, q)) ** 2).sum()) for i in range(rows.n)]
    taken = {k.hypothesis.axis for k in known}
    loaded = any(load.bit is not None for load in rows.model.loads)

    def least(score: Score) -> float:
        hypothesis = score.hypothesis
        axis = hypothesis.axis
        if loaded:
            return np.inf
        if isinstance(hypothesis, EffectHypothesis) and hypothesis.slow:
            return 0.0
        if axis is None:
            return sum(left) / 4
        return np.inf if {axis, None} & taken else left[axis] / 4

    return least


def one_cause(accepted: Sequence[Accepted]) -> list[Accepted]:
    """The same, with the name that most axes can have where several that are equally simple would
    do on each, and the fuller form of an effect where another axis needs it: one cause is simpler
    than two. What an axis has already is no other name for something beside it."""
    needed = {each.score.hypothesis.id for each in accepted}
    places = [_by_name(each) for each in accepted]
    count = Counter(name for own in places for name in own)
    there = {(a.score.hypothesis.axis, a.score.hypothesis.id) for a in accepted}
    unified = []
    for each, own in zip(accepted, places, strict=True):
        if fuller := [s for s in each.fuller if s.hypothesis.id in needed]:
            unified.append(replace(each, score=fuller[0]))
            continue
        first = each.score.hypothesis
        same = [
            name
            for name, score in own.items()
            if score.hypothesis.freedom == first.freedom
            and (name == first.id or (first.axis, name) not in there)
        ]
        name = max(same, key=lambda name: (count[name], name == first.id))
        rivals = tuple(score for score in own.values() if score is not own[name])
        unified.append(replace(each, score=own[name], rivals=rivals, fuller=()))
    return unified


def _by_name(accepted: Accepted) -> dict[str, Score]:
    """What was accepted and its rivals; a rival may be the same effect with another shape."""
    own = dict[str, Score]()
    for score in (accepted.score, *accepted.rivals):
        own.setdefault(score.hypothesis.id, score)
    return own


def as_good(gain: float, best: float, error: float, criteria: Criteria) -> bool:
    """Whether a gain [nats] is about as large as the best one, but for chance and for a relative
    error of the form."""
    return best - gain < log(criteria.odds) + error**2 * best

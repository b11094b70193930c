"""What is accepted of the hypotheses of a round: the simplest of those that predict best."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import log

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.selection.criteria import Criteria
from flexhex.diagnosis.selection.evidence import Tried, evidences, tried
from flexhex.diagnosis.selection.hypotheses import Hypotheses
from flexhex.diagnosis.selection.hypothesis import (
    Axis,
    ChangedParameter,
    EffectHypothesis,
)
from flexhex.diagnosis.selection.moments import Left, Moments
from flexhex.diagnosis.selection.scores import (
    Score,
    change_scores,
    effect_score,
)

Array = NDArray[np.float64]
Say = Callable[[str], None]


@dataclass(frozen=True)
class Accepted:
    """A hypothesis that was chosen in a round (from 1), and those that predict equally well;
    fuller: effects among these that it is a part of."""

    score: Score
    rivals: tuple[Score, ...]
    round: int
    fuller: tuple[Score, ...] = ()


@dataclass(frozen=True)
class Bars:
    """Least gains [nats]: of a hypothesis of any kind, as all together raise as few false alarms as
    wanted; of an effect that another axis has, which has as many chances as there are axes."""

    first: float
    again: float


def chosen(
    moments: Moments,
    known: Sequence[Score],
    scores: Sequence[Score],
    bars: Bars,
    number: int,
    criteria: Criteria,
) -> Accepted | None:
    """What is accepted of the scores of a round beside those that are known."""
    alone = unrepeated(moments, known)
    good = [s for s in scores if beyond_chance(s, known, bars, criteria)]
    for score in good:
        again = _again(score, known)
        if shown(score, criteria, again) and score.gain > alone[score.hypothesis.axis]:
            return simplest(score, good, number, criteria)
    return None


def passes(score: Score, known: Sequence[Score], bars: Bars, criteria: Criteria) -> bool:
    """Whether a hypothesis is accepted beside those that are known."""
    there = shown(score, criteria, _again(score, known))
    return there and beyond_chance(score, known, bars, criteria)


def beyond_chance(score: Score, known: Sequence[Score], bars: Bars, criteria: Criteria) -> bool:
    """Whether a hypothesis is large enough and predicts more than chance beside those that are
    known.

    An effect that is there already, on another axis or with another shape, is no surprise; with
    another shape on the same axis it is large enough as a whole.
    """
    again, effect = _again(score, known), (score.hypothesis.id, score.hypothesis.axis)
    whole = any((k.hypothesis.id, k.hypothesis.axis) == effect for k in known)
    large = whole or score.size > criteria.smallest_effect
    least = bars.again if again else bars.first
    least += log(score.hypothesis.choices) + blurred(score, known, criteria)
    return large and score.gain > least


def _again(score: Score, known: Sequence[Score]) -> bool:
    return any(k.hypothesis.id == score.hypothesis.id for k in known)


def shown(score: Score, criteria: Criteria, again: bool = False) -> bool:
    """Whether a fold confirms what others say of a hypothesis, or another axis does `again`, and
    none speaks against it by more than errors in its form."""
    unsure, error = log(criteria.odds), form_error(score, criteria)
    there = again or score.confirmed > unsure
    return there and score.worst > -unsure - error**2 * score.gain


def form_error(score: Score, criteria: Criteria) -> float:
    """Relative error of a hypothesis' functional form."""
    exact = isinstance(score.hypothesis, EffectHypothesis) and score.hypothesis.exact
    return criteria.exact_form_error if exact else criteria.form_error


def blurred(score: Score, known: Sequence[Score], criteria: Criteria) -> float:
    """What errors in the form of accepted effects on the same axis may have left [nats] that their
    columns (`form.py`) do not show, as they are smooth: how friction turns over, above all."""
    axis = score.hypothesis.axis
    own = [k for k in known if axis is None or k.hypothesis.axis in (axis, None)]
    return sum(form_error(k, criteria) ** 2 * k.gain for k in own)


def bars_of(hypotheses: Hypotheses, criteria: Criteria) -> Bars:
    """Of all hypotheses, and a payload."""
    n = hypotheses.rows.n
    count = sum(len(hypotheses.bench.names(axis)) for axis in (*range(n), None))
    count += len(hypotheses.changes) + 1
    return Bars(log(count / criteria.false_alarms), log(criteria.odds * n))


def effect_scores(
    moments: Moments,
    hypotheses: Hypotheses,
    known: Sequence[Score],
    criteria: Criteria,
    axes: Iterable[Axis],
) -> list[Score]:
    """Scores of the most promising effects of each of these axes beside those that are known; what
    is a part of another one can only take its place."""
    found = list[Score]()
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
                found.append(effect_score(moments, hypotheses, effect, fits))
    return found


def _fitted(
    moments: Moments, effect: EffectHypothesis
) -> tuple[float, EffectHypothesis, dict[Left, Tried]]:
    """What an effect gains on left-out folds, and its fits."""
    fits = tried(moments, effect)
    whole, without = evidences(fits, moments.rows.folds)
    return float((whole - without).sum()), effect, fits


def parameter_scores(moments: Moments, hypotheses: Hypotheses, criteria: Criteria) -> list[Score]:
    """Scores of the base parameters that are not free yet."""
    closed = (c for c in hypotheses.changes if not set(c.places) <= set(moments.freed))
    return change_scores(moments, closed, criteria)


def best_first(scores: Iterable[Score]) -> list[Score]:
    """Those that gain anything."""
    return sorted((s for s in scores if s.gain > 0), key=lambda score: -score.gain)


def simplest(best: Score, scores: Sequence[Score], number: int, criteria: Criteria) -> Accepted:
    """The hypothesis with the fewest free numbers of those, each beyond chance, that predict as
    well as the best one on its axis; the others are its rivals, but for those that only extend
    it."""
    axis, error = best.hypothesis.axis, form_error(best, criteria)
    near = [
        score
        for score in scores
        if score is best
        or (
            (score.hypothesis.axis == axis or isinstance(score.hypothesis, ChangedParameter))
            and as_good(score.gain, best.gain, max(error, form_error(score, criteria)), criteria)
        )
    ]
    first = min(near, key=lambda score: (score.hypothesis.freedom, -score.gain))
    fuller = [s for s in near if s.hypothesis.extends == first.hypothesis.id]
    rivals = [s for s in near if s is not first and s not in fuller]
    return Accepted(first, tuple(rivals), number, tuple(fuller))


def unrepeated(moments: Moments, known: Sequence[Score]) -> Mapping[int | None, float]:
    """Least gain [nats] of an effect on each axis, or on the whole, where nothing repeats.

    Nothing but another trajectory speaks for it then. What explains less than half of all that is
    left is not named, nor is what stands beside an effect that is known, or a payload.
    """
    rows, q = moments.rows, moments.fit(None).q
    if rows.pairs.nnz:
        return dict.fromkeys([None, *range(rows.n)], 0.0)
    left = [float(((rows.white_y[i] - moments.white(i, q)) ** 2).sum()) for i in range(rows.n)]
    taken = {k.hypothesis.axis for k in known}
    taken |= {None for load in rows.made.loads if load.bit is not None}
    least = [np.inf if {i, None} & taken else square / 4 for i, square in enumerate(left)]
    return {None: sum(left) / 4, **dict(enumerate(least))}


def one_cause(accepted: Sequence[Accepted]) -> list[Accepted]:
    """The same, with the name that most axes can have where several that are equally simple would
    do on each, and the fuller form of an effect where another axis needs it: one cause is simpler
    than two."""
    needed = {each.score.hypothesis.id for each in accepted}
    places = [{s.hypothesis.id: s for s in (a.score, *a.rivals)} for a in accepted]
    count = Counter(name for own in places for name in own)
    found = []
    for each, own in zip(accepted, places, strict=True):
        if fuller := [s for s in each.fuller if s.hypothesis.id in needed]:
            found.append(replace(each, score=fuller[0]))
            continue
        first = each.score.hypothesis
        same = [n for n, s in own.items() if s.hypothesis.freedom == first.freedom]
        name = max(same, key=lambda name: (count[name], name == first.id))
        rivals = tuple(score for score in own.values() if score is not own[name])
        found.append(Accepted(own[name], rivals, each.round))
    return found


def as_good(gain: float, best: float, error: float, criteria: Criteria) -> bool:
    """Whether a gain [nats] is about as large as the best one, but for chance and for a relative
    error of the form."""
    return best - gain < log(criteria.odds) + error**2 * best

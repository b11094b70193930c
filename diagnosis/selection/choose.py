"""The search: the simplest hypothesis that predicts best is accepted, until nothing gains.

    y = B q + accepted terms + what is asked for + noise

Every hypothesis answers the same question: how much better does it predict trajectories that it was
not fitted to, and how large is it?
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import log

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.candidates import Bench
from flexhex.diagnosis.selection.criteria import USUAL, Criteria
from flexhex.diagnosis.selection.evidence import evidences, tried
from flexhex.diagnosis.selection.hypotheses import (
    ChangedParameter,
    EffectHypothesis,
    Hypotheses,
)
from flexhex.diagnosis.selection.moments import Moments
from flexhex.diagnosis.selection.rows import Rows
from flexhex.diagnosis.selection.scores import (
    Score,
    change_score,
    effect_score,
    effect_term,
    generic_score,
)

Array = NDArray[np.float64]
Say = Callable[[str], None]


@dataclass(frozen=True)
class Accepted:
    """A hypothesis that was chosen, and those that predict equally well."""

    score: Score
    rivals: tuple[Score, ...]


@dataclass(frozen=True)
class Rest:
    """What repeats of an axis' torque and is explained by nothing: relative RMS, and how many
    standard errors it stands above zero."""

    size: float
    deviations: float


@dataclass(frozen=True)
class Selection:
    """What was chosen, in its order; what is left on each axis, before and after; all scores of
    every round.

    arbitrated: there was another trajectory to predict. beside: of each axis something without a
    name beside all that was accepted; unsure: nats below which it may be noise, by axis.
    """

    accepted: tuple[Accepted, ...]
    arbitrated: bool
    beside: tuple[Score, ...]
    unsure: Mapping[int | None, float]
    before: tuple[Rest, ...]
    rest: tuple[Rest, ...]
    rounds: tuple[tuple[Score, ...], ...]


def select(bench: Bench, criteria: Criteria = USUAL, say: Say = lambda text: None) -> Selection:
    """Accept hypotheses until none gains enough on left-out trajectories."""
    rows = Rows.of(bench.made)
    hypotheses = Hypotheses(bench, rows)
    moments = hypotheses.moments
    before = rest_of(moments)
    least = enough(hypotheses, criteria)
    accepted, rounds = list[Accepted](), list[tuple[Score, ...]]()
    while len(accepted) < criteria.most:
        say(f"effects, round {len(rounds) + 1}")
        scores = one_round(moments, hypotheses, [a.score for a in accepted], criteria)
        rounds.append(tuple(scores))
        known = [each.score for each in accepted]
        alone = unrepeated(moments, known)
        passed = [
            s
            for s in scores
            if passes(s, known, least, criteria) and s.gain > alone[s.hypothesis.axis]
        ]
        if not passed:
            break
        found = simplest(passed[0], scores, criteria)
        accepted.append(found)
        moments = with_accepted(moments, hypotheses, found.score, criteria)
    accepted = one_cause(accepted)
    arbitrated = len({block.run.trajectory for block in bench.made.blocks}) > 1
    beside = [generic_score(moments, hypotheses.generic(axis)) for axis in range(rows.n)]
    return Selection(
        tuple(accepted),
        arbitrated,
        tuple(beside),
        unrepeated(moments, [a.score for a in accepted]),
        before,
        rest_of(moments),
        tuple(rounds),
    )


def passes(score: Score, known: Sequence[Score], least: float, criteria: Criteria) -> bool:
    """Whether a hypothesis is large enough and predicts well enough beside those that are known.

    An effect that another axis has already is no surprise, and as a whole it is large enough.
    """
    axes = {k.hypothesis.axis for k in known if k.hypothesis.id == score.hypothesis.id}
    again = bool(axes) and score.hypothesis.axis not in axes
    least = log(criteria.odds) if again else least
    large = again or score.size > criteria.smallest_effect
    least += log(score.hypothesis.choices) + blurred(score, known, criteria)
    return large and score.gain > least and shown(score, criteria)


def shown(score: Score, criteria: Criteria) -> bool:
    """Whether more than one fold shows a hypothesis, and none speaks against it by more than errors
    in its form."""
    unsure, error = log(criteria.odds), form_error(score, criteria)
    return score.elsewhere > unsure and score.worst > -unsure - error**2 * score.gain


def form_error(score: Score, criteria: Criteria) -> float:
    """Relative error of a hypothesis' functional form."""
    exact = isinstance(score.hypothesis, EffectHypothesis) and score.hypothesis.exact
    return criteria.exact_form_error if exact else criteria.form_error


def blurred(score: Score, known: Sequence[Score], criteria: Criteria) -> float:
    """What errors in the form of accepted effects on the same axis may have left [nats]: nature is
    not the library's form, and a share of an effect's energy is no evidence for another one."""
    axis = score.hypothesis.axis
    own = [k for k in known if axis is None or k.hypothesis.axis in (axis, None)]
    return sum(form_error(k, criteria) ** 2 * k.gain for k in own)


def enough(hypotheses: Hypotheses, criteria: Criteria) -> float:
    """Least gain [nats] of a hypothesis that is accepted: all together raise as few false alarms as
    wanted."""
    axes = (*range(hypotheses.rows.n), None)
    count = sum(len(hypotheses.bench.names(axis)) for axis in axes) + len(hypotheses.changes)
    return float(np.log(count / criteria.false_alarms))


def one_round(
    moments: Moments, hypotheses: Hypotheses, known: Sequence[Score], criteria: Criteria
) -> list[Score]:
    """Scores of the most promising hypotheses of each axis, best first."""
    found = list[Score]()
    for axis in (*range(moments.rows.n), None):
        listed = []
        for effect in hypotheses.effects(axis):
            if sum((effect.id, axis) == _place(k) for k in known) < effect.most:
                fits = tried(moments, effect)
                whole, without = evidences(fits, moments.rows.folds)
                listed.append((float((whole - without).sum()), effect, fits))
        listed.sort(key=lambda item: -item[0])
        for gain, effect, fits in listed[: criteria.shortlist]:
            if gain > 0:
                found.append(effect_score(moments, hypotheses, effect, fits))
    for change in hypotheses.changes:
        if not set(change.places) <= set(moments.freed):
            found.append(change_score(moments, change, criteria))
    return sorted((s for s in found if s.gain > 0), key=lambda score: -score.gain)


def _place(score: Score) -> tuple[str, int | None]:
    return score.hypothesis.id, score.hypothesis.axis


def simplest(best: Score, scores: Sequence[Score], criteria: Criteria) -> Accepted:
    """The hypothesis with the fewest free numbers of those that predict as well as the best one on
    its axis; the others are its rivals, but for those that only extend it."""
    axis = best.hypothesis.axis
    near = [
        score
        for score in scores
        if score is best
        or (
            (score.hypothesis.axis == axis or isinstance(score.hypothesis, ChangedParameter))
            and as_good(score, best, criteria)
        )
    ]
    chosen = min(near, key=lambda score: (score.hypothesis.freedom, -score.gain))
    rivals = [
        score
        for score in near
        if score is not chosen and score.hypothesis.extends != chosen.hypothesis.id
    ]
    return Accepted(chosen, tuple(rivals))


def unrepeated(moments: Moments, known: Sequence[Score]) -> Mapping[int | None, float]:
    """Least gain [nats] of an effect on each axis, or on the whole, where nothing repeats.

    Noise moves the joints as well and is in the columns. What explains less than half of all that
    is left may be the answer of the feedback to it, and so may all beside an effect that is known.
    """
    rows, q = moments.rows, moments.fit(None).q
    if rows.pairs.nnz:
        return dict.fromkeys([None, *range(rows.n)], 0.0)
    left = [float(((rows.white_y[i] - moments.white_X[i] @ q) ** 2).sum()) for i in range(rows.n)]
    taken = {k.hypothesis.axis for k in known}
    least = [np.inf if {i, None} & taken else square / 4 for i, square in enumerate(left)]
    return {None: sum(left) / 4, **dict(enumerate(least))}


def one_cause(accepted: Sequence[Accepted]) -> list[Accepted]:
    """The same, with the name that most axes can have where several that are equally simple would
    do on each: one cause is simpler than two."""
    places = [{s.hypothesis.id: s for s in (a.score, *a.rivals)} for a in accepted]
    count = Counter(name for own in places for name in own)
    found = []
    for each, own in zip(accepted, places, strict=True):
        first = each.score.hypothesis
        same = [n for n, s in own.items() if s.hypothesis.freedom == first.freedom]
        name = max(same, key=lambda name: (count[name], name == first.id))
        rivals = tuple(score for score in own.values() if score is not own[name])
        found.append(Accepted(own[name], rivals))
    return found


def as_good(score: Score, best: Score, criteria: Criteria) -> bool:
    """Whether a hypothesis predicts about as well as the best one, but for chance and for errors in
    the form of either."""
    error = max(form_error(score, criteria), form_error(best, criteria))
    return best.gain - score.gain < log(criteria.odds) + error**2 * best.gain


def with_accepted(
    moments: Moments, hypotheses: Hypotheses, score: Score, criteria: Criteria
) -> Moments:
    """The model with a hypothesis accepted."""
    hypothesis = score.hypothesis
    if isinstance(hypothesis, ChangedParameter):
        return moments.loosened(hypothesis.places, criteria.loose**-2.0)
    return moments.extended(effect_term(moments, hypotheses, score))


def rest_of(moments: Moments) -> tuple[Rest, ...]:
    """What passes have in common of each axis in the fit to all folds, and nothing explains: it
    repeats, or comes again with the opposite sign, as an oscillation of its own may."""
    rows, q, pairs = moments.rows, moments.fit(None).q, moments.rows.pairs
    weight = float(pairs.sum()) or np.inf
    chance = float(np.sqrt(2.0 * (pairs.data**2).sum())) or np.inf
    found = []
    for i in range(rows.n):
        left = rows.level(rows.y[i] - moments.X[i] @ q)
        white = rows.level(rows.white_y[i] - moments.white_X[i] @ q)
        size = np.sqrt(abs(float(left @ (pairs @ left))) / weight) / rows.torque_rms[i]
        # whitened noise has a variance of one
        sure = abs(float(white @ (pairs @ white))) / chance
        found.append(Rest(float(size), sure))
    return tuple(found)

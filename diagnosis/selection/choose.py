"""The search: the simplest hypothesis that predicts best is accepted, until nothing gains.

    y = B q + accepted terms + what is asked for + noise

Every hypothesis answers the same question: how much better does it predict trajectories that it was
not fitted to, and how large is it?
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import log

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.candidates import Bench
from flexhex.diagnosis.selection.criteria import USUAL, Criteria
from flexhex.diagnosis.selection.evidence import predicted, tried
from flexhex.diagnosis.selection.hypotheses import (
    ChangedParameter,
    EffectHypothesis,
    Hypotheses,
    Payload,
)
from flexhex.diagnosis.selection.moments import Moments
from flexhex.diagnosis.selection.payload import payload_score
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

    def matters(self, criteria: Criteria) -> bool:
        """Whether it is large and sure enough."""
        return self.size > criteria.smallest_rest and self.deviations > criteria.deviations


@dataclass(frozen=True)
class Selection:
    """What was chosen, in its order; what is left on each axis, before and after; all scores of
    every round, from the last payload on. bench: of the base model with the payloads that were
    found.

    arbitrated: there was another trajectory to predict. alone: of each axis the generic hypothesis
    in place of what was accepted there; beside: the same beside all that was accepted.
    """

    accepted: tuple[Accepted, ...]
    arbitrated: bool
    alone: tuple[Score, ...]
    beside: tuple[Score, ...]
    before: tuple[Rest, ...]
    rest: tuple[Rest, ...]
    rounds: tuple[tuple[Score, ...], ...]
    bench: Bench
    payloads: tuple[Accepted, ...] = ()


def select(bench: Bench, criteria: Criteria = USUAL, say: Say = lambda text: None) -> Selection:
    """Accept hypotheses until none gains enough on left-out trajectories.

    With a payload all begins anew: what was accepted without it may have taken its place.
    """
    payloads = list[Accepted]()
    while True:
        found = _selected(bench, criteria, say)
        if not isinstance(found, Accepted):
            return replace(found, payloads=tuple(payloads))
        assert isinstance(found.score.hypothesis, Payload)
        payloads.append(found)
        bench = found.score.hypothesis.bench


def _selected(bench: Bench, criteria: Criteria, say: Say) -> Selection | Accepted:
    """The same beside one base model, up to the first payload."""
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
        passed = [s for s in scores if passes(s, least + blurred(s, known, criteria), criteria)]
        if not passed:
            break
        found = simplest(passed[0], scores, criteria)
        if isinstance(found.score.hypothesis, Payload):
            return found
        accepted.append(found)
        moments = with_accepted(moments, found.score, criteria)
    arbitrated = len({block.run.trajectory for block in bench.made.blocks}) > 1
    axes = range(rows.n)
    others = [[a for a in accepted if a.score.hypothesis.axis != axis] for axis in axes]
    alone = [
        generic_score(rebuilt(hypotheses, own, criteria), hypotheses.generic(axis))
        for axis, own in zip(axes, others, strict=True)
    ]
    beside = [generic_score(moments, hypotheses.generic(axis)) for axis in axes]
    return Selection(
        tuple(accepted),
        arbitrated,
        tuple(alone),
        tuple(beside),
        before,
        rest_of(moments),
        tuple(rounds),
        bench,
    )


def carrying(bench: Bench, criteria: Criteria = USUAL) -> Bench:
    """The same beside a payload, if the runs show one before any effect is known."""
    hypotheses = Hypotheses(bench, Rows.of(bench.made))
    score = payload_score(hypotheses.moments, hypotheses, (), criteria)
    if score is None or not passes(score, enough(hypotheses, criteria), criteria):
        return bench
    assert isinstance(score.hypothesis, Payload)
    return score.hypothesis.bench


def rebuilt(hypotheses: Hypotheses, accepted: Sequence[Accepted], criteria: Criteria) -> Moments:
    """The model with these accepted."""
    moments = hypotheses.moments
    for each in accepted:
        moments = with_accepted(moments, each.score, criteria)
    return moments


def passes(score: Score, least: float, criteria: Criteria) -> bool:
    """Whether a hypothesis is large enough, and predicts well enough on more than one fold."""
    large = score.size > criteria.smallest_effect
    least += log(score.hypothesis.choices)
    return large and score.gain > least and score.elsewhere > log(criteria.odds)


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
    count = sum(len(hypotheses.bench.names(axis)) for axis in axes) + len(hypotheses.changes) + 1
    return float(np.log(count / criteria.false_alarms))


def one_round(
    moments: Moments, hypotheses: Hypotheses, known: Sequence[Score], criteria: Criteria
) -> list[Score]:
    """Scores of the most promising hypotheses of each axis, best first."""
    payload = payload_score(moments, hypotheses, known, criteria)
    found = [payload] if payload else list[Score]()
    for axis in (*range(moments.rows.n), None):
        listed = []
        for effect in hypotheses.effects(axis):
            if sum((effect.id, axis) == _place(k) for k in known) < effect.most:
                fits = tried(moments, effect)
                listed.append((float(predicted(moments, fits).sum()), effect, fits))
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


def as_good(score: Score, best: Score, criteria: Criteria) -> bool:
    """Whether a hypothesis predicts about as well as the best one, but for chance and for errors in
    the form of either."""
    error = max(form_error(score, criteria), form_error(best, criteria))
    return best.gain - score.gain < log(criteria.odds) + error**2 * best.gain


def with_accepted(moments: Moments, score: Score, criteria: Criteria) -> Moments:
    """The model with a hypothesis accepted."""
    hypothesis = score.hypothesis
    if isinstance(hypothesis, ChangedParameter):
        return moments.loosened(hypothesis.places, criteria.loose**-2.0)
    assert isinstance(hypothesis, EffectHypothesis)
    return moments.extended(effect_term(moments, hypothesis, score.shape))


def rest_of(moments: Moments) -> tuple[Rest, ...]:
    """What repeats of each axis in the fit to all folds and is explained by nothing."""
    rows, q, pairs = moments.rows, moments.fit(None).q, moments.rows.pairs
    weight = float(pairs.sum()) or np.inf
    chance = float(np.sqrt(2.0 * (pairs.data**2).sum())) or np.inf
    found = []
    for i in range(rows.n):
        left = rows.y[i] - moments.X[i] @ q
        white = rows.white_y[i] - moments.white_X[i] @ q
        size = np.sqrt(max(float(left @ (pairs @ left)) / weight, 0.0)) / rows.torque_rms[i]
        # whitened noise has a variance of one
        sure = float(white @ (pairs @ white)) / chance
        found.append(Rest(float(size), sure))
    return tuple(found)

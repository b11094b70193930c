"""What a hypothesis must gain to be accepted: more than chance, more than errors of form leave."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import log

from flexhex.diagnosis.selection.changed import ChangedParameter
from flexhex.diagnosis.selection.criteria import Criteria
from flexhex.diagnosis.selection.hypotheses import Hypotheses
from flexhex.diagnosis.selection.hypothesis import EffectHypothesis
from flexhex.diagnosis.selection.scores import Score

Plainly = Callable[[Score], Score]
"""A score beside the same model without errors of the form of what was accepted."""


@dataclass(frozen=True)
class Bars:
    """Least gains [nats]: of a hypothesis of any kind, as all together raise as few false alarms as
    wanted; of an effect that another axis has, which has as many chances as there are axes; beside
    that, what errors in the form of accepted effects may have left for it (`blur.py`), if there are
    any.
    """

    first: float
    again: float
    blur: Callable[[Score], float] | None = None


def bars_of(hypotheses: Hypotheses, criteria: Criteria) -> Bars:
    """Of all hypotheses, and a payload."""
    n = hypotheses.rows.n
    count = sum(len(hypotheses.bench.names(axis)) for axis in (*range(n), None))
    count += len(hypotheses.changes) + 1
    return Bars(log(count / criteria.false_alarms), log(criteria.odds * n))


def passes(score: Score, known: Sequence[Score], bars: Bars, criteria: Criteria) -> bool:
    """Whether a hypothesis is accepted beside those that are known."""
    there = shown(score, criteria, repeated(score, known))
    return there and beyond_chance(score, known, bars, criteria)


def beyond_chance(
    score: Score,
    known: Sequence[Score],
    bars: Bars,
    criteria: Criteria,
    plainly: Plainly = lambda score: score,
) -> bool:
    """Whether a hypothesis is large enough and predicts more than chance beside those that are
    known and the errors of their form; and, without these errors, more than they could have left.

    An effect that is there already, on another axis or with another shape, is no surprise; with
    another shape on the same axis it is large enough as a whole.
    """
    effect, least = (score.hypothesis.id, score.hypothesis.axis), chance(score, known, bars)
    whole = any((k.hypothesis.id, k.hypothesis.axis) == effect for k in known)
    if score.gain <= least:
        return False
    if bars.blur is not None and not isinstance(score.hypothesis, ChangedParameter):
        # what these errors do to base parameters is in the doubt of these
        least += bars.blur(score)
    small = 0.0 if whole else criteria.smallest_effect

    def enough(score: Score) -> bool:
        return score.gain > least and score.size > small

    return enough(score) or (bars.blur is not None and enough(plainly(score)))


def chance(score: Score, known: Sequence[Score], bars: Bars) -> float:
    """What a hypothesis may gain by chance beside those that are known [nats]."""
    least = bars.again if repeated(score, known) else bars.first
    return (least + log(score.hypothesis.choices)) * score.doubt


def shown(score: Score, criteria: Criteria, again: bool = False) -> bool:
    """Whether a fold confirms what others say of a hypothesis, or another axis does `again`, and
    none speaks against it by more than errors in its form."""
    unsure, error = log(criteria.odds), form_error(score, criteria)
    there = again or score.confirmed > unsure
    return there and score.worst > -unsure - error**2 * score.gain


def form_error(score: Score, criteria: Criteria) -> float:
    """Relative error of a hypothesis' functional form."""
    exact = isinstance(score.hypothesis, EffectHypothesis) and score.hypothesis.exact
    return criteria.error_of(exact)


def repeated(score: Score, known: Sequence[Score]) -> bool:
    """Whether the same effect is known, on any axis."""
    return any(k.hypothesis.id == score.hypothesis.id for k in known)

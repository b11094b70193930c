"""An effect that is the fuller form of another one: that whole, or its part and something else."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

from flexhex.diagnosis.selection.bars import Bars, form_error
from flexhex.diagnosis.selection.choose import Accepted, as_good, effect_scores
from flexhex.diagnosis.selection.criteria import Criteria
from flexhex.diagnosis.selection.evidence import tried
from flexhex.diagnosis.selection.hypotheses import Hypotheses
from flexhex.diagnosis.selection.hypothesis import EffectHypothesis
from flexhex.diagnosis.selection.moments import Moments
from flexhex.diagnosis.selection.scores import Score, effect_score, effect_term


def in_parts(
    moments: Moments,
    hypotheses: Hypotheses,
    accepted: Accepted | None,
    listed: Sequence[Score],
    known: Sequence[Score],
    bars: Bars,
    criteria: Criteria,
) -> Accepted | None:
    """The part of an effect in the place of the whole, if this and a second effect together
    predict as well in no more free numbers."""
    if accepted is None:
        return None
    whole, axis = accepted.score, accepted.score.hypothesis.axis
    parts = [s for s in listed if s.hypothesis.id == whole.hypothesis.extends]
    parts = [s for s in parts if s.hypothesis.axis == axis]
    for part in (*parts, *_without_optional(moments, hypotheses, whole, criteria)):
        beside = moments.extended(effect_term(moments, hypotheses, part))
        most = whole.hypothesis.freedom - part.hypothesis.freedom
        others = effect_scores(beside, hypotheses, [*known, part], criteria, [axis])
        for other in (s for s in others if s.hypothesis.freedom <= most):
            # without what may be left out it is no other form, so as exact
            same = part.hypothesis.id == whole.hypothesis.id
            gain, error = part.gain + other.gain, 0.0 if same else form_error(whole, criteria)
            if as_good(gain, whole.gain, error, criteria) and other.gain > bars.first:
                return replace(accepted, score=part, fuller=(whole,))
    return accepted


def _without_optional(
    moments: Moments, hypotheses: Hypotheses, whole: Score, criteria: Criteria
) -> list[Score]:
    """The same effect without the shapes that may be left out, if it has any of these."""
    own = whole.hypothesis
    if not isinstance(own, EffectHypothesis) or own.freedom == own.least:
        return []
    every = hypotheses.effect(own.id, own.axis)
    plain = replace(hypotheses.shaped(every, *every.plain), choices=own.choices)
    fits = tried(moments, plain)
    return [effect_score(moments, hypotheses, plain, fits, criteria.error_of(own.exact))]


def with_wholes(accepted: Sequence[Accepted], criteria: Criteria) -> list[Accepted]:
    """The same, with the whole as a rival of a part in its place beside which nothing was found
    in the end."""

    def better(one: Accepted) -> tuple[Score, ...]:
        gain, left = one.score.gain, [s for s in one.fuller if s not in one.rivals]
        return tuple(
            s for s in left if not as_good(gain, s.gain, form_error(s, criteria), criteria)
        )

    single = alone(accepted)
    return [replace(a, rivals=a.rivals + better(a)) if a in single else a for a in accepted]


def alone(accepted: Sequence[Accepted]) -> list[Accepted]:
    """Those that are the only one on their axis."""
    count = Counter(a.score.hypothesis.axis for a in accepted)
    return [a for a in accepted if count[a.score.hypothesis.axis] == 1]


def shape_left_out(accepted: Accepted) -> Score | None:
    """The same effect with the shapes that were left out of it for a second effect, if any."""
    own = (s for s in accepted.fuller if s.hypothesis.id == accepted.score.hypothesis.id)
    return next(own, None)

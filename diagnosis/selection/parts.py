"""An effect that is the fuller form of another one: that whole, or its part and something else."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

from flexhex.diagnosis.selection.bars import Bars, form_error
from flexhex.diagnosis.selection.choose import Accepted, as_good, effect_scores
from flexhex.diagnosis.selection.criteria import Criteria
from flexhex.diagnosis.selection.hypotheses import Hypotheses
from flexhex.diagnosis.selection.moments import Moments
from flexhex.diagnosis.selection.scores import Score, effect_term


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
    if accepted is None or not accepted.score.hypothesis.extends:
        return accepted
    whole, axis = accepted.score, accepted.score.hypothesis.axis
    parts = [s for s in listed if s.hypothesis.id == whole.hypothesis.extends]
    for part in (s for s in parts if s.hypothesis.axis == axis):
        beside = moments.extended(effect_term(moments, hypotheses, part))
        most = whole.hypothesis.freedom - part.hypothesis.freedom
        others = effect_scores(beside, hypotheses, [*known, part], criteria, [axis])
        for other in (s for s in others if s.hypothesis.freedom <= most):
            gain, error = part.gain + other.gain, form_error(whole, criteria)
            if as_good(gain, whole.gain, error, criteria) and other.gain > bars.first:
                return replace(accepted, score=part, fuller=(whole,))
    return accepted


def with_wholes(accepted: Sequence[Accepted], criteria: Criteria) -> list[Accepted]:
    """The same, with the whole as a rival of a part in its place beside which nothing was found
    in the end."""
    count = Counter(a.score.hypothesis.axis for a in accepted)

    def better(one: Accepted) -> tuple[Score, ...]:
        gain, left = one.score.gain, [s for s in one.fuller if s not in one.rivals]
        return tuple(
            s for s in left if not as_good(gain, s.gain, form_error(s, criteria), criteria)
        )

    return [
        replace(a, rivals=a.rivals + better(a)) if count[a.score.hypothesis.axis] == 1 else a
        for a in accepted
    ]

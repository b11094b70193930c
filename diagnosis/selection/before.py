"""Effects with the shapes that they had before, beside another model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import log

from flexhex.diagnosis.selection.choose import Accepted
from flexhex.diagnosis.selection.criteria import Criteria
from flexhex.diagnosis.selection.hypotheses import Hypotheses
from flexhex.diagnosis.selection.hypothesis import EffectHypothesis
from flexhex.diagnosis.selection.moments import Moments
from flexhex.diagnosis.selection.scores import Score, with_shape


def better_of(
    moments: Moments, hypotheses: Hypotheses, scores: Sequence[Score], before: Sequence[Score]
) -> list[Score]:
    """Scores of effects beside a model, and of those that were there before, with the shapes that
    they had: of each effect the better one. The peaks of a grid are others beside another model,
    and none may lead to the best shape."""
    effects = [score for score in before if isinstance(score.hypothesis, EffectHypothesis)]
    best = dict[str, Score]()
    for score in (*scores, *(with_shape(moments, hypotheses, score) for score in effects)):
        known = best.setdefault(score.hypothesis.id, score)
        if score.gain > known.gain:
            best[score.hypothesis.id] = score
    return list(best.values())


def with_rivals_of(
    before: Accepted, now: Accepted, scores: Sequence[Score], criteria: Criteria
) -> Accepted:
    """What was chosen anew, with fuller forms of it that were rivals before and still predict
    better by more than chance: beside errors of the forms of others, which may take up what is
    theirs alone, their own torque looks small."""
    ids = {s.hypothesis.id for s in before.fuller if s in before.rivals}
    listed = [s for s in scores if s.hypothesis.id in ids and s not in now.rivals]
    same = now.score.hypothesis.id == before.score.hypothesis.id
    more = [s for s in listed if same and s.gain - now.score.gain > log(criteria.odds)]
    return replace(now, rivals=(*now.rivals, *more))

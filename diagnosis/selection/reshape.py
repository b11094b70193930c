"""Shapes of accepted effects, moved together to where they are beside all that was found since.

Each shape was fitted in the model of its round, in which others were still missing. With c(s) the
columns of an effect, gains g and a step d of its shape,

    c(s + d) g = c(s) g + d dc/ds g,

so that one linear fit with these tangents as columns says how far all shapes are off.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.jointfit.stacked import beside
from flexhex.diagnosis.selection.criteria import Criteria
from flexhex.diagnosis.selection.hypotheses import Hypotheses
from flexhex.diagnosis.selection.hypothesis import EffectHypothesis
from flexhex.diagnosis.selection.moments import Moments, Term
from flexhex.diagnosis.selection.scores import Score
from flexhex.fmus.common.effects import Shape

Array = NDArray[np.float64]


def reshaped(
    moments: Moments,
    hypotheses: Hypotheses,
    known: Mapping[int, tuple[Score, Term]],
    criteria: Criteria,
) -> dict[int, EffectHypothesis]:
    """Effects of a model whose shapes are surely others beside all the rest of it, with these
    shapes; known: effects and their terms, by any number. Not one whose shape would be beyond a
    bound where this is another effect."""
    listed = [(k, hypotheses.searched(_effect(score))) for k, (score, _) in known.items()]
    searched = [(k, shape) for k, own in listed for shape in own if shape.low < shape.high]
    if not searched:
        return {}
    tangents = [_tangent(moments, hypotheses, *known[k], shape) for k, shape in searched]
    white = {
        i: np.column_stack([t.get(i, np.zeros(moments.rows.count)) for t in tangents])
        for i in sorted({i for t in tangents for i in t})
    }
    spans = np.array([shape.high - shape.low for _, shape in searched])
    steps = Term(MappingProxyType({}), white, spans**-2.0)
    longer = moments.extended(steps)
    place, fit = np.arange(longer.m)[longer.place(steps)], longer.fit(None)
    sure = np.abs(fit.q[place]) / np.sqrt(np.diag(fit.covariance(place)))
    moved = dict[int, EffectHypothesis]()
    for k, (score, _) in known.items():
        effect = _effect(score)
        shape, ended = dict(effect.shapes[score.shape]), False
        for (own, within), far, step in zip(searched, sure, fit.q[place], strict=True):
            if own == k and far > criteria.deviations:
                there = float(np.clip(shape[within.name] + step, within.low, within.high))
                ended |= within.closed and there == within.high
                shape[within.name] = there
        if shape != effect.shapes[score.shape] and not ended:
            moved[k] = hypotheses.shaped(effect, shape)
    return moved


def _effect(score: Score) -> EffectHypothesis:
    assert isinstance(score.hypothesis, EffectHypothesis)
    return score.hypothesis


def _tangent(
    moments: Moments, hypotheses: Hypotheses, score: Score, term: Term, shape: Shape
) -> dict[int, Array]:
    """Change (R,) of an effect's whitened torque with its shape, on each axis that feels it."""
    effect = _effect(score)
    own = effect.shapes[score.shape]
    there = [k for k in range(effect.width) if k not in score.still]
    gains = moments.fit(None).q[moments.place(term)][: len(there)]
    ends = beside(shape, own[shape.name])
    below, above = (hypotheses.columns(effect, {**own, shape.name: end}).white for end in ends)
    return {i: (above[i] - below[i])[:, there] @ gains / (ends[1] - ends[0]) for i in above}

"""Shapes of accepted effects, moved together to where they are beside all that was found since.

Each shape was fitted in the model of its round, in which others were still missing. With c(s) the
columns of an effect, gains g and a step d of its shape,

    c(s + d) g = c(s) g + d dc/ds g,

so that one linear fit with these tangents as columns says how far all shapes are off.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
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
) -> dict[int, Score]:
    """Effects of a model whose shapes are surely others beside all the rest of it, with these
    shapes; known: effects and their terms, by any number."""
    searched = [(k, shape) for k, (s, _) in known.items() for shape in _searched(hypotheses, s)]
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
    moved = dict[int, Score]()
    for k in {k for (k, _), far in zip(searched, sure, strict=True) if far > criteria.deviations}:
        effect = known[k][0].hypothesis
        assert isinstance(effect, EffectHypothesis)
        shape = dict(effect.shapes[known[k][0].shape])
        for (own, within), step in zip(searched, fit.q[place], strict=True):
            if own == k:
                there = shape[within.name] + step
                shape[within.name] = float(np.clip(there, within.low, within.high))
        moved[k] = replace(known[k][0], hypothesis=hypotheses.shaped(effect, shape), shape=0)
    return moved


def _searched(hypotheses: Hypotheses, score: Score) -> list[Shape]:
    effect = score.hypothesis
    assert isinstance(effect, EffectHypothesis)
    return hypotheses.searched(effect)


def _tangent(
    moments: Moments, hypotheses: Hypotheses, score: Score, term: Term, shape: Shape
) -> dict[int, Array]:
    """Change (R,) of an effect's whitened torque with its shape, on each axis that feels it."""
    effect = score.hypothesis
    assert isinstance(effect, EffectHypothesis)
    own = effect.shapes[score.shape]
    there = [k for k in range(effect.width) if k not in score.still]
    gains = moments.fit(None).q[moments.place(term)][: len(there)]
    ends = beside(shape, own[shape.name])
    below, above = (hypotheses.columns(effect, {**own, shape.name: end}).white for end in ends)
    return {i: (above[i] - below[i])[:, there] @ gains / (ends[1] - ends[0]) for i in above}

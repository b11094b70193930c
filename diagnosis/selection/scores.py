"""What a hypothesis adds to the log density of left-out trajectories, and how large it is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import log

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.regression.design import Design
from flexhex.diagnosis.regression.doubt import doubt
from flexhex.diagnosis.selection.changed import Axis, ChangedParameter
from flexhex.diagnosis.selection.evidence import (
    Tried,
    evidences,
    free,
    mean_of,
    tried,
)
from flexhex.diagnosis.selection.hypotheses import Hypotheses
from flexhex.diagnosis.selection.hypothesis import EffectHypothesis, Hypothesis
from flexhex.diagnosis.selection.moments import Left, Moments, Term
from flexhex.diagnosis.selection.refine import ended, refined
from flexhex.diagnosis.selection.rows import Rows

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Score:
    """A hypothesis beside a model. whole: evidence of all folds, without (folds,): of all but each,
    relative to the model alone [nats]; size: relative RMS of its torque beyond what the model takes
    up; shape: place of the best one by all folds; still: places of gains that are zero there, as
    they may not be negative; spread: of each axis the share that it feels of that torque, as base
    parameters carry it over, in squares beside the noise; empty beside the base model alone; doubt:
    how often rows say the same again of it, beside all that it leaves; price: what its best shape
    has more evidence than all shapes together, as nobody knew which it is [nats]; fitted: numbers
    of its shape that were fitted to all folds."""

    hypothesis: Hypothesis
    whole: float
    without: Array
    size: float
    shape: int = 0
    still: tuple[int, ...] = ()
    spread: tuple[float, ...] = ()
    doubt: float = 1.0
    price: float = 0.0
    fitted: int = 0

    @property
    def order(self) -> float | None:
        """Of a wave over the angle [1/rad]; None of anything else."""
        if not isinstance(self.hypothesis, EffectHypothesis):
            return None
        return dict(self.hypothesis.shapes[self.shape]).get("order")

    @property
    def by_fold(self) -> Array:
        """What it adds to the log predictive density of each left-out fold (folds,) [nats]."""
        return self.whole - self.without

    @property
    def gain(self) -> float:
        """What it adds to the log predictive density of all folds [nats].

        Parameters follow the other folds beyond their tolerances, too: that they changed predicts
        nothing more, but the tolerances speak against it. Of these, the evidence.
        """
        if isinstance(self.hypothesis, ChangedParameter):
            return self.whole
        return float(self.by_fold.sum())

    @property
    def confirmed(self) -> float:
        """The lesser of what other folds say of it and what it then adds to one that they predict,
        for the fold that confirms it best: no single one decides [nats]. Parameters follow the
        other folds, changed or not: of these what is left without any fold, if that is more."""
        predicted = float(np.minimum(self.without, self.by_fold).max())
        if isinstance(self.hypothesis, ChangedParameter):
            return max(predicted, float(self.without.min()))
        return predicted

    @property
    def effect(self) -> tuple[str, Axis, Mapping[str, float]]:
        """What makes it the same one as another: name, axis, shape."""
        own = self.hypothesis
        shape = own.shapes[self.shape] if isinstance(own, EffectHypothesis) else {}
        return own.id, own.axis, shape

    @property
    def worst(self) -> float:
        """What it adds to the fold that it predicts worst: below zero, this one speaks against it
        [nats]."""
        return 0.0 if isinstance(self.hypothesis, ChangedParameter) else float(self.by_fold.min())


def effect_score(
    moments: Moments,
    hypotheses: Hypotheses,
    effect: EffectHypothesis,
    fits: Mapping[Left, Tried],
    error: float,
    beside: Moments,
) -> Score:
    """An effect with its best shape, on left-out folds; error: of its form, relative; beside: the
    model in which that shape is chosen, see `lookalike.py`."""
    evidence = fits[None].evidence
    price = max(float(evidence.max()) - mean_of(evidence), log(effect.choices))
    searched = hypotheses.searched(effect)
    if searched:
        there = fits if beside is moments else tried(beside, effect)
        effect, fits, many = refined(beside, hypotheses, effect, there, error)
        fits = fits if beside is moments else tried(moments, effect)
        price += many
        if ended(moments, hypotheses, effect, fits):
            return Score(effect, 0.0, np.zeros(len(moments.rows.folds)), 0.0)
    score = _scored(moments, hypotheses, effect, fits)
    return replace(score, price=price, fitted=len(searched))


def with_shape(moments: Moments, hypotheses: Hypotheses, score: Score) -> Score:
    """The score of the same effect with the same shape beside another model."""
    assert isinstance(score.hypothesis, EffectHypothesis)
    effect = hypotheses.shaped(score.hypothesis, score.hypothesis.shapes[score.shape])
    anew = _scored(moments, hypotheses, effect, tried(moments, effect))
    return replace(anew, price=score.price, fitted=score.fitted)


def _scored(
    moments: Moments, hypotheses: Hypotheses, effect: EffectHypothesis, fits: Mapping[Left, Tried]
) -> Score:
    shape = int(np.argmax(fits[None].evidence))
    gains = fits[None].gains[shape]
    columns = hypotheses.columns(effect, effect.shapes[shape])
    torque = {i: own @ gains for i, own in columns.raw.items()}
    rows = moments.rows
    white = {i: own @ gains for i, own in columns.white.items()}
    cross = moments.pulled({i: rows.across(own) for i, own in white.items()})
    taken_up = moments.fit(None).solve(cross)
    sizes = sizes_of(moments, -taken_up, torque)
    still = tuple(int(k) for k in np.flatnonzero((gains == 0) & (effect.low == 0)))
    spread = spread_of(rows, sizes) if moments.terms and effect.axis is not None else ()
    often = doubt_of(moments, -taken_up, white)
    return Score(
        effect, *evidences(fits, rows.folds), float(sizes.max()), shape, still, spread, often
    )


def effect_term(moments: Moments, hypotheses: Hypotheses, score: Score) -> Term:
    """An effect of its best shape as a term, without gains that are zero as they may not be
    negative."""
    effect = score.hypothesis
    assert isinstance(effect, EffectHypothesis)
    columns = hypotheses.columns(effect, effect.shapes[score.shape])
    there = [k for k in range(effect.width) if k not in score.still]
    raw, white = ({i: v[:, there] for i, v in of.items()} for of in (columns.raw, columns.white))
    return Term(raw, white, free(moments, effect, effect.beside(moments))[score.shape][there])


def blended_term(hypotheses: Hypotheses, score: Score, term: Term, gains: Array) -> Term:
    """The term of an effect with a share of another shape beside its own, up to all of it, where
    real ones have several at once; gains (k,): about those of its columns."""
    effect = score.hypothesis
    assert isinstance(effect, EffectHypothesis)
    shape = hypotheses.blended(effect, effect.shapes[score.shape])
    if shape is None:
        return term
    there = [k for k in range(effect.width) if k not in score.still]
    other = hypotheses.columns(effect, shape)
    raw, white = (
        {i: np.column_stack([v, (more[i][:, there] - v) @ gains]) for i, v in own.items()}
        for own, more in ((term.raw, other.raw), (term.white, other.white))
    )
    return Term(raw, white, np.append(term.prior, 1.0))


def size_of(moments: Moments, step: Array, torque: Mapping[int, Array]) -> float:
    """Relative RMS of a torque (R,) [N m] of some axes and a step (m,) of the coefficients of the
    model together, on the axis of these that feels them most."""
    sizes = []
    for i, own in torque.items():
        whole = moments.torque(i, step) + own
        sizes.append(float(np.sqrt((whole**2).mean()) / moments.rows.torque_rms[i]))
    return max(sizes)


def doubt_of(moments: Moments, step: Array, white: Mapping[int, Array]) -> float:
    """How often rows say the same again of a whitened torque (R,) of some axes, for which the
    coefficients of the model make a step (m,), beside what both leave in the other passes: noise of
    the torque itself says nothing again there."""
    rows, q = moments.rows, moments.fit(None).q
    cluster = rows.model.layout.cluster[rows.model.layout.rows(0)]
    columns, left = list[Array](), list[Array]()
    for i, own in white.items():
        added = moments.white(i, step) + own
        columns.append(added[:, None])
        left.append(rows.across(rows.white_y[i] - moments.white(i, q) - added))
    return float(doubt(Design.of(columns), left, cluster)[0])


def torque_beyond(moments: Moments, hypotheses: Hypotheses, score: Score) -> Array:
    """Whitened torque (R,) of an effect on its axis, beyond what a model takes up."""
    effect = score.hypothesis
    assert isinstance(effect, EffectHypothesis)
    assert effect.axis is not None
    one = hypotheses.shaped(effect, effect.shapes[score.shape])
    gains = tried(moments, one, [None])[None].gains[0]
    columns = hypotheses.columns(effect, effect.shapes[score.shape])
    white = {i: own @ gains for i, own in columns.white.items()}
    cross = moments.pulled({i: moments.rows.across(own) for i, own in white.items()})
    step = moments.fit(None).solve(cross)
    return np.asarray(white[effect.axis] - moments.white(effect.axis, step))


def sizes_of(moments: Moments, step: Array, torque: Mapping[int, Array]) -> Array:
    """The same on every axis (n,): what takes up a torque on one makes some on others."""
    sizes = moments.sizes(step) / moments.rows.torque_rms
    for i, own in torque.items():
        sizes[i] = size_of(moments, step, {i: own})
    return np.asarray(sizes)


def spread_of(rows: Rows, sizes: Array) -> tuple[float, ...]:
    """Of each axis the share of squares, beside the noise, of a torque of these relative sizes."""
    squares = (sizes * rows.white_rms) ** 2
    return tuple((squares / max(float(squares.sum()), np.finfo(float).tiny)).tolist())

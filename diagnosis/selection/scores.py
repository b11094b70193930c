"""Log predictive density of left-out trajectories: what a hypothesis adds to it, in closed form.

Everything is Gaussian once the shapes are given: with G, c the products of whitened columns and
torque, and S, r those of a hypothesis' columns beside the model (its Schur complement),

    log Z = r' (S + P)^-1 r / 2 - log |S + P| / 2 + log |P| / 2

is the evidence for it, relative to the model alone. The evidence of all trajectories minus that of
all but one is the log density at which the one is predicted: base parameters, gains and shapes are
those of the others, with their uncertainty. (P. A. Murphy, Machine Learning, 2012, 7.6; the Schur
complement of the base model makes the search free of rows.)
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import chain, combinations

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

from flexhex.diagnosis.selection.criteria import Criteria
from flexhex.diagnosis.selection.hypotheses import (
    ChangedParameter,
    EffectHypothesis,
    Generic,
    Hypotheses,
    Hypothesis,
)
from flexhex.diagnosis.selection.moments import Left, Moments, Term

Array = NDArray[np.float64]
SIZES = (3e-4, 1e-3, 3e-3, 1e-2, 3e-2, 1e-1)
"""Coefficients of the generic hypothesis, one standard deviation relative to the torque's RMS."""
HALVINGS = 4
"""Of the distance between shapes of a grid."""
GONE = 1e-5
"""Share of a column's square below which the base model explains all of it."""


@dataclass(frozen=True)
class Score:
    """A hypothesis beside a model. by_fold (folds,): what it adds to the log predictive density of
    each left-out fold [nats]; size: relative RMS of its torque beyond what the model takes up;
    shape: place of the best one by all folds."""

    hypothesis: Hypothesis
    by_fold: Array
    size: float
    shape: int = 0

    @property
    def elsewhere(self) -> float:
        """The same without the fold that is predicted best: no single one decides."""
        return self.gain - float(self.by_fold.max())

    @property
    def gain(self) -> float:
        """What it adds to the log predictive density of all folds [nats]."""
        return float(self.by_fold.sum())


@dataclass(frozen=True)
class Tried:
    """All shapes of an effect fitted beside a model, one fold left out or none: evidence (shapes,)
    relative to the model alone, gains (shapes, k)."""

    evidence: Array
    gains: Array


def tried(moments: Moments, effect: EffectHypothesis) -> dict[Left, Tried]:
    """An effect beside a model: fitted to all folds, and to all but each."""
    rows, k = moments.rows, effect.width
    parts: dict[int, tuple[Array, Array, Array]] = {}
    for fold in rows.folds:
        cross = np.zeros((moments.m, len(effect.shapes) * k))
        for i, columns in effect.stacked.items():
            cross += moments.between(effect, i, columns, fold)
        parts[fold] = cross, *effect.products(rows, fold)
    least = np.array([_least(effect, moments)])
    found: dict[Left, Tried] = {}
    for left in (None, *rows.folds):
        cross, right, own = (
            sum(part[j] for fold, part in parts.items() if fold != left) for j in range(3)
        )
        found[left] = _fitted(moments, left, (cross, right, own), effect.low, least)
    return found


def _least(effect: EffectHypothesis, moments: Moments) -> float:
    """Inverse variance of a whitened gain whose torque has an RMS like the axis' own."""
    rows = moments.rows
    axes = list(effect.white)
    return float(np.mean([rows.white_rms[i] ** -2.0 for i in axes]))


def _fitted(
    moments: Moments,
    left: Left,
    products: tuple[Array, Array, Array],
    low: Array,
    least: Array,
) -> Tried:
    cross, right, own = products
    fit, k = moments.fit(left), len(low)
    moved = fit.solve(cross)
    rest = (right - cross.T @ fit.q).reshape(-1, k)
    evidence, gains = np.zeros(len(own)), np.zeros((len(own), k))
    count = (
        float((moments.rows.fold != left).sum()) if left is not None else float(moments.rows.count)
    )
    for shape in range(len(own)):
        part = slice(shape * k, shape * k + k)
        S, size = own[shape] - cross[:, part].T @ moved[:, part], np.diag(own[shape])
        if (np.diag(S) <= GONE * size).any() or (size <= 0).any():
            continue
        prior = float(least[0]) * size / count
        A = (S + S.T) / 2 + np.diag(prior)
        gains[shape], fall = bounded(A, rest[shape], low)
        evidence[shape] = (fall - np.linalg.slogdet(A)[1] + np.log(prior).sum()) / 2
    return Tried(evidence, gains)


def bounded(S: Array, c: Array, low: Array) -> tuple[Array, float]:
    """Gains (k,) that minimise g^T S g - 2 c^T g, those with low = 0 not negative; the fall."""
    positive = low == 0
    best, fall = np.zeros(len(c)), 0.0
    sets = chain.from_iterable(combinations(range(len(c)), n) for n in range(len(c), 0, -1))
    for chosen in (list(s) for s in sets):
        gains = np.linalg.solve(S[np.ix_(chosen, chosen)], c[chosen])
        if (gains[positive[chosen]] < 0).any():
            continue
        if float(c[chosen] @ gains) > fall:
            best, fall = np.zeros(len(c)), float(c[chosen] @ gains)
            best[chosen] = gains
        if len(chosen) == len(c):
            break
    return best, fall


def predicted(moments: Moments, fits: Mapping[Left, Tried]) -> Array:
    """What an effect, any of its shapes, adds to the log density of each left-out fold (folds,)."""
    total = {left: float(logsumexp(fit.evidence)) for left, fit in fits.items()}
    return np.array([total[None] - total[fold] for fold in moments.rows.folds])


def refined(
    moments: Moments, hypotheses: Hypotheses, effect: EffectHypothesis, fits: Mapping[Left, Tried]
) -> tuple[EffectHypothesis, dict[Left, Tried]]:
    """An effect with its best shape alone, between the points of its grid: uphill in evidence from
    the best of them, half the distance to its neighbours each time."""
    start = effect.shapes[int(np.argmax(fits[None].evidence))]
    best = hypotheses.shaped(effect, start)
    found = tried(moments, best)
    for level in range(1, HALVINGS + 1):
        for name, low, high, _ in hypotheses.searched(effect):
            for value in _beside_of(effect, start, best.shapes[0], name, level):
                if low <= value <= high:
                    other = hypotheses.shaped(effect, {**best.shapes[0], name: value})
                    trial = tried(moments, other)
                    if trial[None].evidence[0] > found[None].evidence[0]:
                        best, found = other, trial
    return best, found


def _beside_of(
    effect: EffectHypothesis,
    start: Mapping[str, float],
    now: Mapping[str, float],
    name: str,
    level: int,
) -> list[float]:
    """Values on both sides of a shape's present one: the way to the neighbours on the grid of where
    the search began, halved `level` times."""
    values = sorted({shape[name] for shape in effect.shapes})
    place = values.index(start[name])
    below = values[place] - values[max(place - 1, 0)]
    above = values[min(place + 1, len(values) - 1)] - values[place]
    # beyond the ends of the grid as far as inside
    below, above = below or above, above or below
    return [now[name] - below / 2**level, now[name] + above / 2**level]


def effect_score(
    moments: Moments, hypotheses: Hypotheses, effect: EffectHypothesis, fits: Mapping[Left, Tried]
) -> Score:
    """An effect with its best shape, on left-out folds."""
    if hypotheses.searched(effect):
        effect, fits = refined(moments, hypotheses, effect, fits)
    shape = int(np.argmax(fits[None].evidence))
    size = size_of(moments, effect_term(moments, effect, shape), fits[None].gains[shape])
    return Score(effect, predicted(moments, fits), size, shape)


def effect_term(moments: Moments, effect: EffectHypothesis, shape: int) -> Term:
    """An effect of one shape as a term."""
    white = {i: own[shape] for i, own in effect.white.items()}
    size = sum((own**2).mean(axis=0) for own in white.values())
    prior = _least(effect, moments) * np.maximum(size, 1e-300)
    return Term({i: own[shape] for i, own in effect.raw.items()}, white, prior)


def size_of(moments: Moments, term: Term, gains: Array) -> float:
    """Relative RMS of a term's torque beyond what the model takes up, on the axis that feels it
    most."""
    rows = moments.rows
    every = np.ones(rows.count, dtype=bool)
    torques = [(i, (own @ gains)[:, None]) for i, own in term.white.items()]
    step = moments.fit(None).solve(
        sum(rows.between(moments.white_X[i], own, every) for i, own in torques)
    )[:, 0]
    found = []
    for i in range(rows.n):
        torque = -(moments.X[i] @ step)
        if i in term.raw:
            torque = torque + term.raw[i] @ gains
        found.append(float(np.sqrt((torque**2).mean())) / rows.torque_rms[i])
    return max(found)


def generic_score(moments: Moments, generic: Generic) -> Score:
    """The generic hypothesis, of any of its sizes, on left-out folds."""
    rows, axis = moments.rows, generic.axis
    parts = {}
    for fold in rows.folds:
        own = generic.white[rows.fold == fold]
        right = rows.between(generic.white, rows.white_y[axis], rows.fold == fold)
        parts[fold] = moments.between(generic, axis, generic.white, fold), right, own.T @ own
    total: dict[Left, float] = {}
    best, gains = 0, np.zeros(generic.white.shape[1])
    moved = np.zeros(moments.m)
    for left in (None, *rows.folds):
        cross, right, own = (
            sum(part[j] for fold, part in parts.items() if fold != left) for j in range(3)
        )
        fit = moments.fit(left)
        step = fit.solve(cross)
        S = own - cross.T @ step
        values, vectors = np.linalg.eigh((S + S.T) / 2)
        turned = vectors.T @ (right - cross.T @ fit.q)
        evidence = []
        for size in SIZES:
            A = np.maximum(values, 0.0) + size**-2.0
            evidence.append(float((turned**2 / A - np.log(A * size**2)).sum()) / 2)
        total[left] = float(logsumexp(evidence))
        if left is None:
            best = int(np.argmax(evidence))
            gains = vectors @ (turned / (np.maximum(values, 0.0) + SIZES[best] ** -2.0))
            moved = step @ gains
    by_fold = np.array([total[None] - total[fold] for fold in rows.folds])
    torque = generic.raw @ gains - moments.X[axis] @ moved
    size = float(np.sqrt((torque**2).mean()) / rows.torque_rms[axis])
    return Score(generic, by_fold, size, best)


def change_score(moments: Moments, change: ChangedParameter, criteria: Criteria) -> Score:
    """Parameters that may leave their tolerances, on left-out folds."""
    places, looser = list(change.places), criteria.loose**-2.0
    total: dict[Left, float] = {}
    size = 0.0
    for left in (None, *moments.rows.folds):
        fit, (G, b) = moments.fit(left), moments.gram(left)
        columns = G[:, places]
        moved = fit.solve(columns)
        S = columns[places] - columns.T @ moved
        values, vectors = np.linalg.eigh((S + S.T) / 2)
        A = np.maximum(values, 0.0) + looser
        turned = vectors.T @ (b[places] - columns.T @ fit.q)
        total[left] = float((turned**2 / A - np.log(A / looser)).sum()) / 2
        if left is None and total[left] > 0:
            gains = vectors @ (turned / A)
            step = -(moved @ gains)
            step[places] += gains
            pairs = zip(moments.X, moments.rows.torque_rms, strict=True)
            size = max(float(np.sqrt(((X @ step) ** 2).mean())) / rms for X, rms in pairs)
    by_fold = np.array([total[None] - total[fold] for fold in moments.rows.folds])
    return Score(change, by_fold, size)

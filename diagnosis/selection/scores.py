"""How much of what repeats on left-out trajectories a hypothesis explains, and how surely."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain, combinations

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.selection.criteria import Criteria
from flexhex.diagnosis.selection.hypotheses import (
    ChangedParameter,
    EffectHypothesis,
    Hypotheses,
    Hypothesis,
)
from flexhex.diagnosis.selection.moments import Left, Moments, Term

Array = NDArray[np.float64]
RIDGE, GONE = 1e-9, 1e-4
"""Relative to a column's square: what keeps a Gram matrix regular; what is left of a column below
which the base model explains it."""


@dataclass(frozen=True)
class Score:
    """A hypothesis beside a model: fall of the whitened sum of squares where it is fitted; gain on
    left-out folds, a square of relative RMS, with its standard error by clusters; energy
    (clusters,) that it leaves there. shape: place of the best one, by the fit to all folds."""

    hypothesis: Hypothesis
    fall: float
    gain: float
    deviation: float
    energy: Array
    shape: int = 0

    @property
    def size(self) -> float:
        """Relative RMS that it explains on left-out folds."""
        return float(np.sqrt(max(self.gain, 0.0)))

    def passes(self, criteria: Criteria) -> bool:
        """Whether it is large and sure enough."""
        large = self.gain > criteria.smallest_effect**2
        return large and self.gain > criteria.deviations * self.deviation


@dataclass(frozen=True)
class Tried:
    """All shapes of an effect fitted beside a model, `left` left out: falls (shapes,), gains
    (shapes, k), and what they move the model's coefficients by, (m, shapes * k) for gains of
    one."""

    falls: Array
    gains: Array
    moved: Array


def tried(moments: Moments, effect: EffectHypothesis) -> dict[Left, Tried]:
    """An effect beside a model: fitted to all folds, and to all but each."""
    rows, k = moments.rows, effect.width
    parts: dict[int, tuple[Array, Array, Array]] = {}
    for fold in rows.folds:
        where = rows.fold == fold
        cross = np.zeros((moments.m, len(effect.shapes) * k))
        right, own = np.zeros(cross.shape[1]), np.zeros((len(effect.shapes), k, k))
        for i, columns in effect.stacked.items():
            cross += rows.between(moments.white_X[i], columns, where)
            right += rows.between(columns, rows.white_y[i], where)
            single, twin = effect.white[i][:, where], effect.white[i][:, rows.partner][:, where]
            own += np.einsum("sra,srb->sab", single, twin)
        parts[fold] = cross, right, (own + own.transpose(0, 2, 1)) / 2
    found: dict[Left, Tried] = {}
    for left in (None, *rows.folds):
        cross, right, own = (
            sum(part[j] for fold, part in parts.items() if fold != left) for j in range(3)
        )
        found[left] = _fitted(moments, left, (cross, right, own), effect.low)
    return found


def _fitted(
    moments: Moments, left: Left, products: tuple[Array, Array, Array], low: Array
) -> Tried:
    cross, right, own = products
    fit, k = moments.fit(left), len(low)
    moved = fit.solve(cross)
    rest = (right - cross.T @ fit.q).reshape(-1, k)
    falls, gains = np.zeros(len(own)), np.zeros((len(own), k))
    for shape in range(len(own)):
        part = slice(shape * k, shape * k + k)
        S, size = own[shape] - cross[:, part].T @ moved[:, part], np.diag(own[shape])
        if (np.diag(S) <= GONE * size).any():
            continue
        S = (S + S.T) / 2 + np.diag(RIDGE * size)
        gains[shape], falls[shape] = bounded(S, rest[shape], low)
    return Tried(falls, gains, moved)


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


def with_form(
    hypotheses: Hypotheses, effect: EffectHypothesis, shape: int, gains: Array, criteria: Criteria
) -> Term:
    """Columns of an effect, and beside them those by which its form may be wrong."""
    error = criteria.exact_form_error if effect.exact else criteria.form_error
    raw, white = dict[int, Array](), dict[int, Array]()
    for i in effect.raw:
        smooth = hypotheses.smooth[i]
        share = error / np.sqrt(smooth.shape[1])
        for found, own in ((raw, effect.raw[i][shape]), (white, effect.white[i][shape])):
            found[i] = np.hstack([own, share * (own @ gains)[:, None] * smooth])
    wrong = next(iter(raw.values())).shape[1] - effect.width
    return Term(raw, white, np.concatenate([np.zeros(effect.width), np.ones(wrong)]))


def effect_score(
    moments: Moments,
    hypotheses: Hypotheses,
    effect: EffectHypothesis,
    fits: dict[Left, Tried],
    criteria: Criteria,
) -> Score:
    """An effect on left-out folds: shape, gains and form are those of the other folds."""
    rows = moments.rows
    residual = [r.copy() for r in moments.left_out]
    for fold in rows.folds:
        fit = fits[fold]
        shape = int(np.argmax(fit.falls))
        if fit.falls[shape] <= 0:
            continue
        term = with_form(hypotheses, effect, shape, fit.gains[shape], criteria)
        gains, moved = term_fit(moments, term, fold, effect.low)
        where = rows.fold == fold
        for i in range(rows.n):
            residual[i][where] += moments.X[i][where] @ moved
        for i, own in term.raw.items():
            residual[i][where] -= own[where] @ gains
    best = int(np.argmax(fits[None].falls))
    return scored(moments, effect, float(fits[None].falls[best]), residual, best)


def term_fit(moments: Moments, term: Term, left: Left, low: Array) -> tuple[Array, Array]:
    """Coefficients (k,) of a term beside a model, and what they move the model's by (m,)."""
    rows, fit = moments.rows, moments.fit(left)
    where = np.ones(len(rows.fold), dtype=bool) if left is None else rows.fold != left
    count = len(term.prior)
    cross, right, own = np.zeros((moments.m, count)), np.zeros(count), np.zeros((count, count))
    for i, columns in term.white.items():
        cross += rows.between(moments.white_X[i], columns, where)
        right += rows.between(columns, rows.white_y[i], where)
        own += rows.between(columns, columns, where)
    moved = fit.solve(cross)
    S = (own + own.T) / 2 - cross.T @ moved
    S = (S + S.T) / 2 + np.diag(term.prior + RIDGE * np.maximum(np.diag(own), 1e-300))
    rest = right - cross.T @ fit.q
    gains = np.linalg.solve(S, rest)
    negative = np.flatnonzero((low == 0) & (gains[: len(low)] < 0))
    if len(negative):
        others = np.setdiff1d(np.arange(count), negative)
        gains = np.zeros(count)
        gains[others] = np.linalg.solve(S[np.ix_(others, others)], rest[others])
    return gains, moved @ gains


def change_falls(moments: Moments, changes: Sequence[ChangedParameter]) -> Array:
    """Falls of the whitened sum of squares when each parameter may leave its tolerance."""
    if not changes:
        return np.zeros(0)
    fit, (G, b) = moments.fit(None), moments.gram(None)
    places = [change.place for change in changes]
    columns = G[:, places]
    size = np.diag(G)[places]
    left = size - np.einsum("ij,ij->j", columns, fit.solve(columns))
    pull = b[places] - columns.T @ fit.q
    determined = left > GONE**2 * np.maximum(size, 1e-300)
    return np.where(determined, pull**2 / np.maximum(left, 1e-300), 0.0)


def change_score(moments: Moments, change: ChangedParameter, fall: float) -> Score:
    """A parameter without its tolerance, on left-out folds."""
    rows = moments.rows
    residual = [r.copy() for r in moments.left_out]
    for fold in rows.folds:
        fit, (G, b) = moments.fit(fold), moments.gram(fold)
        column = G[:, change.place]
        moved = fit.solve(column)
        left = column[change.place] - column @ moved
        if left <= GONE**2 * column[change.place]:
            continue
        gain = (b[change.place] - column @ fit.q) / left
        step = -gain * moved
        step[change.place] += gain
        where = rows.fold == fold
        for i in range(rows.n):
            residual[i][where] -= moments.X[i][where] @ step
    return scored(moments, change, fall, residual)


def scored(
    moments: Moments, hypothesis: Hypothesis, fall: float, residual: Sequence[Array], shape: int = 0
) -> Score:
    """The score of what a hypothesis leaves (R,) [N m] of each axis on left-out folds."""
    energy = moments.rows.energy(residual)
    gain, deviation = summed(moments.energy - energy)
    return Score(hypothesis, fall, gain, deviation, energy, shape)


def summed(by_cluster: Array) -> tuple[float, float]:
    """Sum over clusters and its standard error."""
    count = len(by_cluster)
    about = by_cluster - by_cluster.mean()
    return float(by_cluster.sum()), float(np.sqrt((about**2).sum() * count / max(1, count - 1)))

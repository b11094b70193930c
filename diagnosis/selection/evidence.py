"""Evidence for columns beside a model, for all shapes of an effect at once and free of rows.

Everything is Gaussian once the shapes are given. With S, r the products of a hypothesis' whitened
columns with each other and with the torque, less what the model takes up of both (its Schur
complement), and P the inverse variance of its gains,

    log Z = r' (S + P)^-1 r / 2 - log |S + P| / 2 + log |P| / 2

is the evidence for it relative to the model alone. The evidence of all folds minus that of all but
one is the log density at which the one is predicted: base parameters, gains and shapes are those of
the others, with their uncertainty.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import chain, combinations

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

from flexhex.diagnosis.selection.hypotheses import EffectHypothesis, Products
from flexhex.diagnosis.selection.moments import Left, Moments

Array = NDArray[np.float64]
GONE = 1e-5
"""Share of a column's square below which the base model explains all of it."""


def products(moments: Moments, effect: EffectHypothesis, left: Left) -> Products:
    """Products of an effect's columns beside a model, of all folds but one."""
    rows = moments.rows
    kept = [effect.products(rows, fold) for fold in rows.folds if fold != left]
    cross = np.sum([part.cross for part in kept], axis=0)
    if moments.terms:
        where = np.ones(rows.count, dtype=bool) if left is None else rows.fold != left
        pairs = [(moments.white_X[i][:, rows.nb :], own) for i, own in effect.stacked.items()]
        more = np.sum([rows.between(X, own, where) for X, own in pairs], axis=0)
        cross = np.vstack([cross, more])
    return Products(
        cross,
        np.sum([part.right for part in kept], axis=0),
        np.sum([part.own for part in kept], axis=0),
    )


@dataclass(frozen=True)
class Tried:
    """All shapes of an effect fitted beside a model, one fold left out or none: evidence (shapes,)
    relative to the model alone, gains (shapes, k)."""

    evidence: Array
    gains: Array


def tried(moments: Moments, effect: EffectHypothesis) -> dict[Left, Tried]:
    """An effect beside a model: fitted to all folds, and to all but each."""
    prior, lefts = free(moments, effect), [None, *moments.rows.folds]
    return {left: _fitted(moments, left, effect, prior) for left in lefts}


def free(moments: Moments, effect: EffectHypothesis) -> Array:
    """Inverse variances (shapes, k) of an effect's gains: its torque may be as large as all that
    the axis feels."""
    squares = np.sum([(own**2).mean(axis=1) for own in effect.white.values()], axis=0)
    torque = np.mean([moments.rows.white_rms[i] ** 2 for i in effect.white])
    return np.asarray(np.maximum(squares, 1e-300) / torque)


def _fitted(moments: Moments, left: Left, effect: EffectHypothesis, priors: Array) -> Tried:
    fit, k, found = moments.fit(left), effect.width, products(moments, effect, left)
    moved = fit.solve(found.cross)
    rest = (found.right - found.cross.T @ fit.q).reshape(-1, k)
    evidence, gains = np.zeros(len(priors)), np.zeros((len(priors), k))
    for shape, (own, prior) in enumerate(zip(found.own, priors, strict=True)):
        part = slice(shape * k, shape * k + k)
        S = own - found.cross[:, part].T @ moved[:, part]
        if (np.diag(S) <= GONE * np.diag(own)).any():
            continue
        A = (S + S.T) / 2 + np.diag(prior)
        gains[shape], fall = bounded(A, rest[shape], effect.low)
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

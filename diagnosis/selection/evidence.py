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

from flexhex.diagnosis.selection.hypotheses import EffectHypothesis
from flexhex.diagnosis.selection.moments import Left, Moments

Array = NDArray[np.float64]
GONE = 1e-5
"""Share of a column's square below which the base model explains all of it."""


@dataclass(frozen=True)
class Products:
    """Of whitened columns with the model's (m, k), with the torque (k,) and with each other."""

    cross: Array
    right: Array
    own: Array


def but(parts: Mapping[int, Products], left: Left) -> Products:
    """Sum over all folds but one."""
    kept = [part for fold, part in parts.items() if fold != left]
    return Products(
        np.sum([part.cross for part in kept], axis=0),
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
    parts: dict[int, Products] = {}
    for fold in moments.rows.folds:
        cross = np.zeros((moments.m, len(effect.shapes) * effect.width))
        for i, columns in effect.stacked.items():
            cross += moments.between(effect, i, columns, fold)
        parts[fold] = Products(cross, *effect.products(moments.rows, fold))
    prior = free(moments, effect)
    lefts: list[Left] = [None, *moments.rows.folds]
    return {left: _fitted(moments, left, but(parts, left), prior, effect.low) for left in lefts}


def free(moments: Moments, effect: EffectHypothesis) -> Array:
    """Inverse variances (shapes, k) of an effect's gains: its torque may be as large as all that
    the axis feels."""
    squares = np.sum([(own**2).mean(axis=1) for own in effect.white.values()], axis=0)
    torque = np.mean([moments.rows.white_rms[i] ** 2 for i in effect.white])
    return np.asarray(np.maximum(squares, 1e-300) / torque)


def _fitted(moments: Moments, left: Left, products: Products, priors: Array, low: Array) -> Tried:
    fit, k = moments.fit(left), len(low)
    moved = fit.solve(products.cross)
    rest = (products.right - products.cross.T @ fit.q).reshape(-1, k)
    evidence, gains = np.zeros(len(priors)), np.zeros((len(priors), k))
    for shape, (own, prior) in enumerate(zip(products.own, priors, strict=True)):
        part = slice(shape * k, shape * k + k)
        S = own - products.cross[:, part].T @ moved[:, part]
        if (np.diag(S) <= GONE * np.diag(own)).any():
            continue
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

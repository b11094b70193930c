"""Evidence for columns beside a model, for all shapes of an effect at once and free of rows.

Everything is Gaussian once the shapes are given. With S, r the products of a hypothesis' whitened
columns with each other and with the torque, less what the model takes up of both (its Schur
complement), and P the inverse variance of its gains,

    log Z = r' (S + P)^-1 r / 2 - log |S + P| / 2 + log |P| / 2

is the evidence for it relative to the model alone. r is of products between passes, S of those
within each: noise of a column must not make it seem small, and what moves differently from pass to
pass is taken up by the model as well. So a gain is smaller by what the model leaves of that. The
evidence of all folds minus that of all but one is the log density at which the one is predicted:
base parameters, gains and shapes are those of the others, with their uncertainty.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.selection.hypothesis import EffectHypothesis
from flexhex.diagnosis.selection.moments import Left, Moments, Term
from flexhex.diagnosis.selection.products import Products

Array = NDArray[np.float64]
INEXACT, CHANCE = 0.1, 3.0
"""Share by which a gain may lie beyond what a machine can have, as forms are not exact, and what it
may cost by chance [nats] to hold it at its bound, the odds of `Criteria`. Halved it changes none of
four cases with eccentric encoders and friction, doubled one (unknown to named rightly)."""
GONE = 1e-5
"""Share of a column's square below which the base model explains all of it."""


@dataclass(frozen=True)
class Tried:
    """All shapes of an effect fitted beside a model, one fold left out or none: evidence (shapes,)
    relative to the model alone, gains (shapes, k); odd (shapes,): they would have to be others than
    a machine can have."""

    evidence: Array
    gains: Array
    odd: NDArray[np.bool_]


def tried(
    moments: Moments, effect: EffectHypothesis, some: Sequence[Left] = ()
) -> dict[Left, Tried]:
    """An effect beside a model: fitted to all folds, and to all but each, or to `some` of these. A
    shape whose gains of all folds no machine can have has no evidence: something else looks like
    it."""
    products, lefts = effect.beside(moments), some or [None, *moments.rows.folds]
    prior = free(moments, effect, products)
    fits = dict(zip(lefts, _fitted(moments, lefts, effect, products, prior), strict=True))
    for fit in fits.values():
        fit.evidence[fits[None].odd] = -np.inf
    return fits


def free(moments: Moments, effect: EffectHypothesis, products: Products) -> Array:
    """Inverse variances (shapes, k) of an effect's gains: its torque may be as large as all that
    the axis feels."""
    rows = moments.rows
    squares = np.diagonal(products.own.sum(axis=0), axis1=1, axis2=2) / rows.count
    torque = np.mean([rows.white_rms[i] ** 2 for i in effect.felt])
    return np.asarray(np.maximum(squares, np.finfo(float).tiny) / torque)


def _fitted(
    moments: Moments,
    lefts: Sequence[Left],
    effect: EffectHypothesis,
    products: Products,
    priors: Array,
) -> list[Tried]:
    """All shapes beside the fit without each of these folds, in one go: of a single shape calls
    take longer than numbers."""
    sums = [products.without(left) for left in lefts]
    beside = [
        _beside(moments, left, effect.width, *own) for left, own in zip(lefts, sums, strict=True)
    ]
    S, rest, there = (np.stack(v) for v in zip(*beside, strict=True))
    gains, odd = np.zeros_like(rest), np.zeros_like(there)
    evidence, falls = np.zeros((2, *there.shape))
    prior = np.broadcast_to(priors, rest.shape)[there]
    A = S[there] + prior[:, :, None] * np.eye(effect.width)
    gains[there], falls[there], odd[there] = _possible(effect, A, rest[there])
    size = np.linalg.slogdet(A)[1] - np.log(prior).sum(axis=1)
    evidence[there] = (falls[there] - size) / 2
    fits = [Tried(*of) for of in zip(evidence, gains, odd, strict=True)]
    for left, (_, right, own), fit, fall, good in zip(lefts, sums, fits, falls, there, strict=True):
        # well beyond what is left no fall is one: products between passes have lost their sign
        beyond = fall - (1 + INEXACT) * moments.most(left)
        fit.evidence[:] -= np.where(beyond > 0, np.inf if left is None else beyond / 2, 0.0)
        if effect.taken is not None and effect.axis is not None:
            lost = _let_through(moments, left, effect.axis, fit, own, right, fall)
            fit.evidence[good] -= lost[good]
            fit.evidence[:] += effect.blind(moments.rows, left, fit.gains)
    return fits


def _beside(
    moments: Moments, left: Left, k: int, cross: Array, right: Array, own: Array
) -> tuple[Array, Array, NDArray[np.bool_]]:
    """What the fit to all folds but one leaves of the products of shapes of k columns, with each
    other (shapes, k, k) and with the torque (shapes, k), and where it leaves any (shapes,); of all
    folds, any of each column."""
    half = moments.within(left).half(cross[-1]).reshape(moments.m, -1, k).transpose(1, 2, 0)
    S = own - half @ half.transpose(0, 2, 1)
    whole, alone = (np.diagonal(v, axis1=1, axis2=2) for v in (own, S))
    rest = (right - cross[0].T @ moments.fit(left).q).reshape(-1, k)
    seen = alone > GONE * whole
    # what left-out rows alone show says nothing without them: the others of the shape still do
    there = np.asarray(seen.all(axis=1) if left is None else seen.any(axis=1))
    S, rest = S * (seen[:, :, None] & seen[:, None, :]), rest * seen
    return S, rest, there


def _let_through(
    moments: Moments, left: Left, axis: int, fit: Tried, own: Array, right: Array, fall: Array
) -> Array:
    """What the evidence (shapes,) for limits of an axis loses: what a limit leaves is as large as
    it is beside the torque that it lets pass. Torque that is taken away leaves little, whatever the
    model says. Bounded where next to nothing passes."""
    gain = fit.gains[:, 0]
    squares, unexplained = moments.left_over(axis, left)
    passed = squares + gain * (gain * own[:, 0, 0] - 2 * right)
    more = max(squares, 0.0) / np.maximum(passed, max(GONE * squares, 1.0)) - 1
    return np.asarray(np.maximum(more, 0) * np.maximum(unexplained - fall, 0) / 2)


def _possible(
    effect: EffectHypothesis, A: Array, c: Array
) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Gains (shapes, k) that a machine can have, their falls (shapes,), and where others would fit
    better than chance and an inexact form explain."""
    signs = np.where(effect.low == 0, 0.0, -np.inf)
    gains, most = bounded(A, c, signs, np.full_like(signs, np.inf))
    beyond, fall = ((gains < effect.low) | (gains > effect.high)).any(axis=1), most.copy()
    gains[beyond], fall[beyond] = bounded(A[beyond], c[beyond], effect.low, effect.high)
    odd = (most - fall) / 2 > CHANCE + INEXACT**2 * most / 2
    if effect.taken is not None:
        # a limit takes all beyond it: one that is not quite the best takes too much or too little
        odd[:] = False
    for less, more, times in effect.ordered:
        odd |= np.abs(gains[:, less]) > (1 + INEXACT) * times * gains[:, more]
    return gains, fall, odd


def bounded(S: Array, c: Array, low: Array, high: Array) -> tuple[Array, Array]:
    """Gains (shapes, k) from low to high (k,) that minimise g^T S g - 2 c^T g for S (shapes, k, k),
    c (shapes, k); the falls (shapes,).

    The least of a convex function is the best of those on the faces of its bounds that lie within.
    """
    pairs = zip(low, high, strict=True)
    ends = [(None, *(end for end in pair if np.isfinite(end))) for pair in pairs]
    faces = sorted(product(*ends), key=lambda face: sum(end is not None for end in face))
    best, fall = np.zeros_like(c), np.full(len(c), -np.inf)
    open_ = np.arange(len(c))
    for face in faces:
        free = [k for k, end in enumerate(face) if end is None]
        gains = np.tile([0.0 if end is None else end for end in face], (len(open_), 1))
        right = c[open_] - (S[open_] @ gains[..., None])[..., 0]
        own = S[open_][:, free][:, :, free]
        gains[:, free] = np.linalg.solve(own, right[:, free, None])[..., 0]
        falls = (gains * (2 * c[open_] - (S[open_] @ gains[..., None])[..., 0])).sum(axis=1)
        fits = ((gains >= low) & (gains <= high)).all(axis=1)
        better = fits & (falls > fall[open_])
        best[open_[better]], fall[open_[better]] = gains[better], falls[better]
        if len(free) == len(low):
            # the minimum over all gains needs no look at fewer
            open_ = open_[~fits]
        if not len(open_):
            break
    return best, fall


def evidences(fits: Mapping[Left, Tried], folds: Sequence[int]) -> tuple[float, Array]:
    """Evidence for an effect, any of its shapes, of all folds and of all but each (folds,).

    That it is there is as likely as that it is not: so a fold can be predicted no better than by
    what the others say of the effect, and where they say that there is none, by none.
    """
    total = {left: _mean(fit.evidence) for left, fit in fits.items()}
    return total[None], np.array([total[fold] for fold in folds])


def _mean(evidence: Array) -> float:
    """Of shapes that are equally likely, together as likely as nothing."""
    return float(np.logaddexp(mean_of(evidence), 0.0) - np.log(2.0))


def mean_of(evidence: Array) -> float:
    """Logarithm of the mean of what has these logarithms (k,), of which some may be -inf."""
    most = float(evidence.max())
    if not np.isfinite(most):
        return most
    return most + float(np.log(np.exp(evidence - most).mean()))


def turned_to(S: Array, r: Array, gone: float = GONE) -> tuple[Array, Array, Array]:
    """Eigenvalues (..., k) of S (..., k, k), r (..., k) in their directions, the directions
    (..., k, k); those of which the model explains all but `gone`, of the largest, are empty."""
    values, vectors = np.linalg.eigh((S + S.swapaxes(-1, -2)) / 2)
    there = values > gone * np.maximum(values[..., -1:], 0.0)
    turned = (vectors.swapaxes(-1, -2) @ r[..., None])[..., 0]
    return np.where(there, values, 0.0), np.where(there, turned, 0.0), vectors


def log_evidence(values: Array, turned: Array, prior: float | Array) -> Array:
    """Evidence (...) for coefficients that all have the same inverse variance."""
    A = values + prior
    return np.asarray((turned**2 / A - np.log(A / prior)).sum(axis=-1) / 2)


def together(moments: Moments, terms: Sequence[Term]) -> float:
    """What terms of a model add, all of them, to the log predictive density of its folds [nats]."""
    folds = moments.rows.folds
    total = len(folds) * evidence_of(moments, terms)
    return total - sum(evidence_of(moments, terms, fold) for fold in folds)


def evidence_of(moments: Moments, terms: Sequence[Term], left: Left = None) -> float:
    """Evidence for terms of a model, all of them, of all folds but one [nats].

    Their gains q and covariance C in the fit of the whole model say it: C^-1 is S + P, and C^-1 q
    is r, beside the model without them, both of products between passes.
    """
    own = np.concatenate([np.arange(moments.m)[moments.place(term)] for term in terms])
    size, fit = moments.prior[own] ** -0.5, moments.fit(left)
    # errors of a form are small beside the effect itself
    covariance: Array = fit.covariance(own) / np.outer(size, size)
    values, vectors = np.linalg.eigh(covariance)
    turned = vectors.T @ (fit.q[own] / size)
    return float((turned**2 / values + np.log(values)).sum()) / 2

"""Scores of something without a name."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.selection.evidence import log_evidence, mean_of, turned_to
from flexhex.diagnosis.selection.left import rest_on
from flexhex.diagnosis.selection.moments import Left, Moments, Term
from flexhex.diagnosis.selection.products import Products
from flexhex.diagnosis.selection.scores import Score, size_of
from flexhex.diagnosis.selection.unnamed import NamelessHypothesis

Array = NDArray[np.float64]
SIZES = (3e-4, 1e-3, 3e-3, 1e-2, 3e-2, 1e-1)
"""Coefficients of the generic hypothesis, one standard deviation relative to the torque's RMS."""
Beside = tuple[Array, Array, Array]
"""The step (m, k) that the coefficients of a fit take for each of some columns, and what it leaves
of the products of these with each other (k, k) and with the torque (k,)."""


def generic_score(
    moments: Moments, listed: Sequence[NamelessHypothesis], sizes: Sequence[float] = SIZES
) -> Score:
    """Something without a name, of any of these kinds and sizes, on left-out folds."""
    folds, products = moments.rows.folds, {k.within: k.within.beside(moments) for k in listed}

    def tried(left: Left) -> list[Sized]:
        beside = {within: _left_of(moments, left, own) for within, own in products.items()}
        return [each for kind in listed for each in _sized(kind, beside[kind.within], sizes)]

    def evidence(every: Sequence[Sized]) -> float:
        return mean_of(np.array([each.evidence for each in every]))

    every = tried(None)
    without = np.array([evidence(tried(fold)) for fold in folds])
    best = _best(every)
    torque = {i: raw @ best.gains for i, raw in best.kind.raw.items()}
    size = size_of(moments, -(best.moved @ best.gains), torque)
    # columns would be kept as long as the score is
    hypothesis = replace(best.kind.columns, columns=lambda _: {}, known=())
    return Score(hypothesis, evidence(every), without, size)


def generic_term(moments: Moments, kind: NamelessHypothesis) -> Term:
    """One kind of something without a name, of the size that has most evidence, as a term."""
    best = _best(_sized(kind, _beside(moments, kind)))
    white = kind.columns.columns(kind.columns.shapes)
    raw, white = ({i: v @ best.way for i, v in of.items()} for of in (kind.raw, white))
    return Term(raw, white, np.full(best.way.shape[1], best.prior))


@dataclass(frozen=True)
class Sized:
    """A kind of something without a name of one size: its evidence [nats], how its coefficients go
    together (k, k'), the inverse variance of these k', gains (k,) of its columns, and the step
    (m, k) that coefficients of the model take for each of these."""

    kind: NamelessHypothesis
    evidence: float
    way: Array
    prior: float
    gains: Array
    moved: Array


def _sized(
    kind: NamelessHypothesis, beside: Beside, sizes: Sequence[float] = SIZES
) -> Iterator[Sized]:
    """A kind in all its ways and of all sizes, beside a model."""
    at, (moved, S, r) = kind.place, beside
    for way in kind.ways:
        values, turned, vectors = turned_to(way.T @ S[at, at] @ way, way.T @ r[at])
        for prior in (size**-2.0 for size in sizes):
            gains = way @ (vectors @ (turned / (values + prior)))
            yield Sized(
                kind, float(log_evidence(values, turned, prior)), way, prior, gains, moved[:, at]
            )


def _best(listed: Iterable[Sized]) -> Sized:
    return max(listed, key=lambda each: each.evidence)


@dataclass(frozen=True)
class Whole:
    """All kinds of something without a name on an axis together, of the size that has most
    evidence: gains (k,) of their columns, and the step (m, k) that coefficients of the model take
    for each of these."""

    moments: Moments
    kind: NamelessHypothesis
    gains: Array
    moved: Array

    @staticmethod
    def of(moments: Moments, kind: NamelessHypothesis) -> Whole:
        """kind: of all together."""
        best = _best(_sized(kind, _beside(moments, kind)))
        return Whole(moments, kind, best.gains, best.moved)

    def part(self, kind: NamelessHypothesis) -> float:
        """Relative RMS of one of the kinds, as far as all together say which it is."""
        gains = self.gains[kind.place]
        torque = {i: raw @ gains for i, raw in kind.raw.items()}
        return size_of(self.moments, -(self.moved[:, kind.place] @ gains), torque)

    def beyond(self, axis: int) -> float:
        """Relative RMS of what repeats on the axis and is none of it."""
        q = self.moments.fit(None).q - self.moved @ self.gains
        listed = self.kind.raw, self.kind.columns.columns(self.kind.columns.shapes)
        raw, white = (of[axis] @ self.gains for of in listed)
        return rest_on(self.moments, axis, q, raw, white).size


def _beside(moments: Moments, kind: NamelessHypothesis) -> Beside:
    return _left_of(moments, None, kind.within.beside(moments))


def _left_of(moments: Moments, left: Left, products: Products) -> Beside:
    """Of columns, beside the fit to all folds but one."""
    cross, right, own = products.without(left)
    fit, half = moments.fit(left), moments.within(left).half(cross[-1])
    return fit.solve(cross[0]), own[0] - half.T @ half, right - cross[0].T @ fit.q

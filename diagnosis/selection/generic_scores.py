"""Scores of something without a name."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.selection.evidence import log_evidence, mean_of, turned_to
from flexhex.diagnosis.selection.left import rest_on
from flexhex.diagnosis.selection.moments import Left, Moments
from flexhex.diagnosis.selection.scores import Score, size_of
from flexhex.diagnosis.selection.solved import Solved
from flexhex.diagnosis.selection.unnamed import NamelessHypothesis

Array = NDArray[np.float64]
SIZES = (3e-4, 1e-3, 3e-3, 1e-2, 3e-2, 1e-1)
"""Coefficients of the generic hypothesis, one standard deviation relative to the torque's RMS."""


def generic_score(
    moments: Moments, listed: Sequence[NamelessHypothesis], sizes: Sequence[float] = SIZES
) -> Score:
    """Something without a name, of any of these kinds and sizes, on left-out folds."""
    rows, total = moments.rows, dict[Left, float]()
    best, size, priors = listed[0].columns, 0.0, [size**-2.0 for size in sizes]
    products = {kind.within: kind.within.beside(moments) for kind in listed}
    for left in [None, *rows.folds]:
        evidence, fit = list[float](), moments.fit(left)
        beside = {within: _left_of(fit, *own.without(left)) for within, own in products.items()}
        for kind in listed:
            at, (moved, S, r) = kind.place, beside[kind.within]
            for way in kind.ways:
                values, turned, vectors = turned_to(way.T @ S[at, at] @ way, way.T @ r[at])
                evidence += [float(log_evidence(values, turned, prior)) for prior in priors]
                if left is None and max(evidence[-len(priors) :]) == max(evidence):
                    prior = priors[int(np.argmax(evidence[-len(priors) :]))]
                    gains = way @ vectors @ (turned / (values + prior))
                    torque = {i: raw @ gains for i, raw in kind.raw.items()}
                    best = kind.columns
                    size = size_of(moments, -(moved[:, at] @ gains), torque)
        total[left] = mean_of(np.array(evidence))
    # columns would be kept as long as the score is
    best = replace(best, columns=lambda _: {}, known=())
    return Score(best, total[None], np.array([total[fold] for fold in rows.folds]), size)


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
        fit, priors = moments.fit(None), [size**-2.0 for size in SIZES]
        moved, S, r = _left_of(fit, *kind.within.beside(moments).without(None))
        way = kind.ways[0]
        values, turned, vectors = turned_to(way.T @ S @ way, way.T @ r)
        prior = max(priors, key=lambda p: float(log_evidence(values, turned, p)))
        return Whole(moments, kind, way @ vectors @ (turned / (values + prior)), moved)

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


def _left_of(fit: Solved, cross: Array, right: Array, own: Array) -> tuple[Array, Array, Array]:
    """What the coefficients of a fit (m, k) do for columns, and what it leaves of their products
    with each other (k, k) and with the torque (k,)."""
    moved = fit.solve(cross)
    return moved, own[0] - cross.T @ moved, right - cross.T @ fit.q

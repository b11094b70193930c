"""A linear fit with what is known of its coefficients, factored once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import LinAlgError, cho_factor, cho_solve
from scipy.linalg.blas import dtrsm

Array = NDArray[np.float64]
FIRM, UNSURE = 1e-8, 1e-6
"""Least curvature, relative to a column's own: added everywhere, so that rounding decides nothing;
and where noise made products between passes negative."""


@dataclass(frozen=True)
class Factor:
    """Products with what is known of their coefficients: factor R and sizes s (m,) of
    G + prior = s R' R s; sure: no direction has products between passes that only noise can
    make."""

    factor: Array
    size: Array
    sure: bool

    def solve(self, right: Array) -> Array:
        """(G + prior)^-1 right, right (m,) or (m, k)."""
        across = self.size if right.ndim == 1 else self.size[:, None]
        return np.asarray(cho_solve((self.factor, False), right / across) / across)

    def half(self, right: Array) -> Array:
        """The half (m, k) of it whose square is right' (G + prior)^-1 right."""
        scaled = np.divide(right, self.size[:, None], order="F")
        return np.asarray(dtrsm(1.0, self.factor, scaled, trans_a=1, overwrite_b=1))

    def covariance(self, places: NDArray[np.int64]) -> Array:
        """(G + prior)^-1 of some coefficients (k, k)."""
        half = self.half(np.eye(len(self.size))[:, places])
        return np.asarray(half.T @ half)


@dataclass(frozen=True)
class Solved(Factor):
    """A fit: coefficients q (m,), too."""

    q: Array

    @staticmethod
    def of(factor: Factor, right: Array) -> Solved:
        """The fit to products with the torque (m,)."""
        return Solved(factor.factor, factor.size, factor.sure, factor.solve(right))


def factor_of(G: Array, prior: Array) -> Factor:
    """Of G + prior; directions that nothing determines stay where they are."""
    own = np.maximum(np.abs(np.diag(G)), prior)
    size = np.sqrt(np.where(own > 0, own, 1.0))
    known, scaled = np.diag(prior / size**2 + FIRM), G / np.outer(size, size)
    factor = _factor(scaled + known)
    sure = factor is not None
    if _factor(scaled + FIRM * np.eye(len(G))) is None:
        # products between passes of what hardly repeats may be negative: nothing repeats then
        values, vectors = np.linalg.eigh(scaled)
        scaled = (vectors * np.maximum(values, 0.0)) @ vectors.T
        factor = _factor(scaled + known + (0.0 if sure else UNSURE) * np.eye(len(G)))
    assert factor is not None
    return Factor(factor, size, sure)


def _factor(square: Array) -> Array | None:
    try:
        return np.asarray(cho_factor(square)[0])
    except LinAlgError:
        return None

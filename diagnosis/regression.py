"""Whitened rows of all runs and the arithmetic that decides: Gram matrices, folds, clusters."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve
from scipy.stats import f as f_distribution

Array = NDArray[np.float64]
Index = NDArray[np.int64]
ABSORBED = 1e-5
"""Share of a column's square below which the base model explains all of it."""


@dataclass(frozen=True)
class Layout:
    """Where rows come from, axis by axis: axis, fold, cluster (R,).

    fold: trajectories (or stretches of the only one) that arbitrate in turn; cluster: about a
    second of one trajectory, all axes and passes of it, within which errors go together.
    """

    axis: Index
    fold: Index
    cluster: Index

    @property
    def folds(self) -> Index:
        """Numbers of the folds."""
        return np.unique(self.fold)

    def rows(self, axis: int | None) -> slice:
        """Rows of an axis; of all when it is None."""
        if axis is None:
            return slice(None)
        bounds = np.searchsorted(self.axis, [axis, axis + 1])
        return slice(int(bounds[0]), int(bounds[1]))


@dataclass(frozen=True)
class Columns:
    """Candidate columns C (rows, k), nonzero in the rows of one axis or, with None, of all."""

    axis: int | None
    values: Array


@dataclass(frozen=True)
class Gain:
    """What candidate columns bring.

    inside: fall of the sum of squares where fitted; outside: summed over folds that were left
    out, as a share (cluster by cluster in `by_cluster`); p: cluster-robust Wald test; beta (k,)
    with its covariance.
    """

    inside: float
    outside: float
    by_cluster: Array
    p: float
    beta: Array
    covariance: Array


@dataclass(frozen=True)
class Regression:
    """y (R,) = B (R, nb) q + noise of unit variance, q ~ N(0, 1 / prior) (nb,).

    known: Gram matrices where they have been computed already.
    """

    y: Array
    B: Array
    prior: Array
    layout: Layout
    known: list[tuple[Array, Array]] | None = None

    @cached_property
    def grams(self) -> list[tuple[Array, Array]]:
        """(B^T B, B^T y) of each fold."""
        if self.known is not None:
            return self.known
        made = []
        for fold in self.layout.folds:
            mine = self.layout.fold == fold
            B = self.B[mine]
            made.append((B.T @ B, B.T @ self.y[mine]))
        return made

    @cached_property
    def _total(self) -> tuple[Array, Array]:
        G, b = np.diag(self.prior), np.zeros(len(self.prior))
        for part, rhs in self.grams:
            G, b = G + part, b + rhs
        return G, b

    @cached_property
    def _factor(self) -> tuple[Array, bool]:
        G, _ = self._total
        jitter = 1e-11 * np.diag(np.maximum(np.diag(G), 1e-300))
        factor: tuple[Array, bool] = cho_factor(G + jitter)
        return factor

    def solve(self, rhs: Array) -> Array:
        """(B^T B + prior)^-1 rhs."""
        return np.asarray(cho_solve(self._factor, rhs))

    @cached_property
    def q(self) -> Array:
        """Estimate (nb,)."""
        return self.solve(self._total[1])

    @cached_property
    def residual(self) -> Array:
        """y - B q (R,)."""
        return np.asarray(self.y - self.B @ self.q)

    def extended(self, columns: list[Columns], prior: Array | None = None) -> Regression:
        """With further columns, free unless they have a prior."""
        C = np.hstack([self._spread(c) for c in columns])
        more = np.zeros(C.shape[1]) if prior is None else prior
        grams = []
        for (G, b), fold in zip(self.grams, self.layout.folds, strict=True):
            mine = self.layout.fold == fold
            own = C[mine]
            cross = self.B[mine].T @ own
            grams.append(
                (
                    np.block([[G, cross], [cross.T, own.T @ own]]),
                    np.concatenate([b, own.T @ self.y[mine]]),
                )
            )
        B = np.hstack([self.B, C])
        return Regression(self.y, B, np.concatenate([self.prior, more]), self.layout, grams)

    def _spread(self, columns: Columns) -> Array:
        if columns.axis is None:
            return columns.values
        full = np.zeros((len(self.y), columns.values.shape[1]))
        full[self.layout.rows(columns.axis)] = columns.values
        return full

    def falls(self, axis: int | None, C: Array, k: int) -> Array:
        """Falls of the sum of squares for candidates of k neighbouring columns each."""
        rows = self.layout.rows(axis)
        cross = self.B[rows].T @ C
        solved = self.solve(cross)
        c = C.T @ self.residual[rows]
        found = []
        for at in range(0, C.shape[1], k):
            part = slice(at, at + k)
            own = C[:, part].T @ C[:, part]
            S = _safe(own - cross[:, part].T @ solved[:, part], own)
            found.append(c[part] @ np.linalg.solve(S, c[part]))
        return np.array(found)

    def fall(self, columns: Columns) -> tuple[float, Array]:
        """Fall of the sum of squares by columns fitted beside the base, and their gains (k,)."""
        rows, C = self.layout.rows(columns.axis), columns.values
        cross = self.B[rows].T @ C
        own = C.T @ C
        S = _safe(own - cross.T @ self.solve(cross), own)
        c = C.T @ self.residual[rows]
        beta = np.linalg.solve(S, c)
        return float(c @ beta), np.asarray(beta)

    def gain(self, columns: Columns) -> Gain:
        """Everything about candidate columns."""
        rows, C = self.layout.rows(columns.axis), columns.values
        inside, beta = self.fall(columns)
        cross = self.B[rows].T @ C
        moved = self.solve(cross)
        clean = -self.B @ moved
        clean[rows] += C
        ideas = -np.sqrt(self.prior)[:, None] * moved
        own = C.T @ C
        A = np.asarray(np.linalg.pinv(_safe(own - cross.T @ moved, own)))
        covariance, p = self._wald(clean, ideas, A, beta)
        outside, by_cluster = self._outside(clean, ideas, own)
        return Gain(inside, outside, by_cluster, p, beta, covariance)

    def _wald(self, clean: Array, ideas: Array, A: Array, beta: Array) -> tuple[Array, float]:
        """Cluster-robust covariance of beta and the p-value of all of it being zero.

        clean (R, k), ideas (nb, k): columns without what the base explains, in the rows and in
        what is known of the parameters; A (k, k): inverse of their Gram matrix.
        """
        k, count = len(beta), self.clusters
        weighted = clean * (self.residual - clean @ beta)[:, None]
        scores = np.column_stack(
            [np.bincount(self.layout.cluster, weights=w, minlength=count) for w in weighted.T]
        )
        factor = count / max(1, count - 1)
        covariance = A @ (factor * scores.T @ scores + ideas.T @ ideas) @ A
        wald = float(beta @ np.linalg.pinv(covariance) @ beta) / k
        return np.asarray(covariance), float(f_distribution.sf(wald, k, max(1, count - 1 - k)))

    @property
    def strain(self) -> float:
        """Sum of squares of the parameters' deviations from what is known of them."""
        return float((self.prior * self.q**2).sum())

    @cached_property
    def clusters(self) -> int:
        """Largest number of a cluster, plus one."""
        return int(self.layout.cluster.max()) + 1

    def _outside(self, clean: Array, ideas: Array, before: Array) -> tuple[float, Array]:
        """Sum of squares without minus with the columns, by gains fitted to the other folds.

        clean (R, k), ideas (nb, k): see `_wald`. The base model is that of all folds: fitted to
        one of them alone it would extrapolate worse than any effect. The last cluster holds by
        how much less the columns strain what is known of the parameters.
        """
        change = np.zeros(len(self.y))
        strained = -np.sqrt(self.prior) * self.q
        own = clean.T @ clean + ideas.T @ ideas
        target = clean.T @ self.residual + ideas.T @ strained
        for fold in self.layout.folds:
            mine = np.flatnonzero(self.layout.fold == fold)
            here = clean[mine]
            S = _safe(own - here.T @ here, before)
            beta = np.linalg.solve(S, target - here.T @ self.residual[mine])
            change[mine] = here @ beta
        beta = np.linalg.solve(_safe(own, before), target)
        fall = self.residual**2 - (self.residual - change) ** 2
        by_cluster = np.bincount(self.layout.cluster, weights=fall, minlength=self.clusters)
        relief = float((strained**2).sum() - ((strained - ideas @ beta) ** 2).sum())
        found = np.append(by_cluster, relief)
        return float(found.sum()), found


def _safe(S: Array, own: Array) -> Array:
    """A Gram matrix of what is left of columns, such that what is absorbed gains nothing.

    own: of the columns before; a column of which less than ABSORBED is left counts as gone.
    """
    size = np.maximum(np.diag(own), 1e-300)
    left = np.diag(S) / size
    return np.asarray(S + np.diag(np.where(left > ABSORBED, 1e-9, 1e9) * size))

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
            S = own - cross[:, part].T @ solved[:, part]
            S += 1e-9 * np.diag(np.diag(own)) + 1e-300 * np.eye(k)
            found.append(c[part] @ np.linalg.solve(S, c[part]))
        return np.array(found)

    def fall(self, columns: Columns) -> tuple[float, Array]:
        """Fall of the sum of squares by columns fitted beside the base, and their gains (k,)."""
        rows, C = self.layout.rows(columns.axis), columns.values
        cross = self.B[rows].T @ C
        S = C.T @ C - cross.T @ self.solve(cross)
        c = C.T @ self.residual[rows]
        S += 1e-9 * np.diag(np.diag(C.T @ C)) + 1e-300 * np.eye(len(S))
        beta = np.linalg.solve(S, c)
        return float(c @ beta), beta

    def gain(self, columns: Columns) -> Gain:
        """Everything about candidate columns."""
        rows, C = self.layout.rows(columns.axis), columns.values
        inside, beta = self.fall(columns)
        cross = self.B[rows].T @ C
        clean = -self.B @ self.solve(cross)
        clean[rows] += C
        error = self.residual - clean @ beta
        covariance, p = self._wald(clean, error, beta)
        outside, by_cluster = self._outside(columns, cross)
        return Gain(inside, outside, by_cluster, p, beta, covariance)

    def _wald(self, clean: Array, error: Array, beta: Array) -> tuple[Array, float]:
        """Cluster-robust covariance of beta and the p-value of all of it being zero."""
        k = len(beta)
        A = np.linalg.pinv(clean.T @ clean)
        weighted = clean * error[:, None]
        count = self.clusters
        scores = np.column_stack(
            [np.bincount(self.layout.cluster, weights=w, minlength=count) for w in weighted.T]
        )
        factor = count / max(1, count - 1)
        covariance = factor * A @ (scores.T @ scores) @ A
        wald = float(beta @ np.linalg.pinv(covariance) @ beta) / k
        return covariance, float(f_distribution.sf(wald, k, max(1, count - 1 - k)))

    @cached_property
    def clusters(self) -> int:
        """Largest number of a cluster, plus one."""
        return int(self.layout.cluster.max()) + 1

    @cached_property
    def _folds(self) -> list[_Fold]:
        """What each fold needs while it is left out."""
        made = []
        for place, fold in enumerate(self.layout.folds):
            mine = np.flatnonzero(self.layout.fold == fold)
            G, b = self._total[0] - self.grams[place][0], self._total[1] - self.grams[place][1]
            factor = cho_factor(G + 1e-11 * np.diag(np.maximum(np.diag(G), 1e-300)))
            q = cho_solve(factor, b)
            B = self.B[mine]
            made.append(_Fold(mine, B, factor, q, self.y[mine] - B @ q))
        return made

    @cached_property
    def left_out(self) -> Array:
        """Residual (R,) of every fold by a fit to the others."""
        residual = np.zeros(len(self.y))
        for fold in self._folds:
            residual[fold.rows] = fold.residual
        return residual

    def _outside(self, columns: Columns, cross: Array) -> tuple[float, Array]:
        """Sum of squares without minus with the columns, on folds that were not fitted."""
        rows, C = self.layout.rows(columns.axis), columns.values
        first, last, _ = rows.indices(len(self.y))
        by_cluster = np.zeros(self.clusters)
        own, target = C.T @ C, C.T @ self.y[rows]
        for fold in self._folds:
            a, b = np.searchsorted(fold.rows, [first, last])
            here, B = C[fold.rows[a:b] - first], fold.B[a:b]
            mixed = cross - B.T @ here
            S = own - here.T @ here
            ridge = 1e-9 * np.diag(np.diag(S)) + 1e-300 * np.eye(len(S))
            S = S - mixed.T @ cho_solve(fold.factor, mixed) + ridge
            rhs = target - here.T @ self.y[fold.rows[a:b]] - mixed.T @ fold.q
            beta = np.linalg.solve(S, rhs)
            after = fold.residual + fold.B @ cho_solve(fold.factor, mixed @ beta)
            after[a:b] -= here @ beta
            fall = fold.residual**2 - after**2
            by_cluster += np.bincount(
                self.layout.cluster[fold.rows], weights=fall, minlength=self.clusters
            )
        return float(by_cluster.sum()), by_cluster


@dataclass(frozen=True)
class _Fold:
    """A fold that is left out: its rows, their B, the fit q to all others and its residual."""

    rows: Index
    B: Array
    factor: tuple[Array, bool]
    q: Array
    residual: Array

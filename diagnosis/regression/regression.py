"""Whitened rows of all runs, and a fit between passes with what is known of the parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.regression.design import Design
from flexhex.diagnosis.regression.gains import Beside, GainEstimate
from flexhex.diagnosis.regression.gram import (
    inverted,
    is_gone,
    safe_gram,
    safe_inverse,
    undetermined,
)
from flexhex.diagnosis.regression.layout import Layout

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Columns:
    """Candidate columns C (rows, k), nonzero in the rows of one axis or, with None, of all."""

    axis: int | None
    values: Array


@dataclass(frozen=True)
class Regression:
    """y (R,) = B (R, nb) q + noise of unit variance, q ~ N(0, 1 / prior) (nb,); rows axis by axis.
    doubt (nb,): how many times prior counts what is known of q, as errors of the model do.

    Products of rows are taken between passes: what does not repeat, in torque or motion, drops
    out of them. (A disturbance moves the joints too; within one pass the feedback's answer to
    it would be taken for dynamics of the machine.) The sum of squares that is fitted is thus
    the one that repeats. Without repeats a row is its own partner: ordinary least squares.

    drifting: candidates change from pass to pass, and are their own partners; the base model's
    columns are not, as the noise in them is no drift. known: B^T B and B^T y between passes, where
    they have been computed already; held: curvature (nb, nb) where noise alone moves the columns,
    likewise.
    """

    y: Array
    B: Design
    prior: Array
    doubt: Array
    layout: Layout
    known: tuple[Array, Array] | None = None
    held: Array | None = None
    drifting: bool = False

    @cached_property
    def gram(self) -> tuple[Array, Array]:
        """B^T B (nb, nb) and B^T y (nb,) between passes."""
        if self.known is not None:
            return self.known
        G, b = np.zeros((self.B.width, self.B.width)), np.zeros(self.B.width)
        for i in range(self.layout.n):
            for place, values in self.B.pieces[i]:
                other = self.layout.across(values, i)
                G[:, place] += self.B.pulled(i, other)
                b[place] += other.T @ self.y[self.layout.rows(i)]
        return (G + G.T) / 2, b

    @cached_property
    def firm(self) -> Array:
        """Curvature (nb, nb) beside the products between passes, where noise alone moves columns of
        free parameters: these stay where they are. Others are held by what is known of them."""
        if self.held is not None:
            return self.held
        G, free = self.gram[0], np.flatnonzero(self.prior == 0)
        if not len(free):
            return np.zeros_like(G)
        own, firm = np.ix_(free, free), np.zeros_like(G)
        within = sum(self.B.squares(i) for i in range(self.layout.n))
        firm[own] = undetermined(G[own], np.asarray(within)[own])
        return firm

    def _other(self, values: Array, axis: int | None = None) -> Array:
        """Candidates or what is left, rows of an axis or all, of the other pass."""
        return values if self.drifting else self.layout.across(values, axis)

    @cached_property
    def covariance(self) -> Array:
        """Of the coefficients (nb, nb) for noise of unit variance: (B^T B + prior)^-1, made safe
        where noise left less than the prior itself."""
        return safe_inverse(self.gram[0] + self.firm + np.diag(self.prior), self.prior)

    def solve(self, rhs: Array) -> Array:
        """(B^T B + prior)^-1 rhs."""
        return np.asarray(self.covariance @ rhs)

    @cached_property
    def q(self) -> Array:
        """Estimate (nb,)."""
        return self.solve(self.gram[1])

    @cached_property
    def residual(self) -> Array:
        """y - B q (R,)."""
        return self.y - self.times(self.q)

    def times(self, q: Array) -> Array:
        """B q (R, ...)."""
        return np.concatenate([self.B.times(i, q) for i in range(self.layout.n)])

    def pulled(self, values: Array, axis: int | None) -> Array:
        """B^T values (nb, ...) of rows of an axis or of all."""
        if axis is not None:
            return self.B.pulled(axis, values)
        parts = (self.B.pulled(i, values[self.layout.rows(i)]) for i in range(self.layout.n))
        return np.asarray(sum(parts))

    def loosened(self, freed: Mapping[int, float]) -> Regression:
        """With other inverse variances of some base parameters, by their place."""
        if not freed:
            return self
        prior = self.prior.copy()
        places = list(freed)
        prior[places] = np.array(list(freed.values())) * self.doubt[places]
        return replace(self, prior=prior, known=self.gram, held=self.firm)

    def only(self, kept: NDArray[np.int64]) -> Regression:
        """With some of the base columns."""
        G, b = self.gram
        own = np.ix_(kept, kept)
        fewer, prior = self.B.only(kept), self.prior[kept]
        products = G[own], b[kept]
        doubt, held = self.doubt[kept], self.firm[own]
        return replace(self, B=fewer, prior=prior, doubt=doubt, known=products, held=held)

    def extended(self, columns: Sequence[Columns]) -> Regression:
        """With further columns, free of any prior."""
        if not columns:
            return self
        (G, b), C = self.gram, np.hstack([self.spread(c) for c in columns])
        other = self._other(C)
        cross, own = self.pulled(self.layout.across(C), None), other.T @ C
        whole = np.block([[G, cross], [cross.T, (own + own.T) / 2]])
        right = np.concatenate([b, other.T @ self.y])
        more = {i: C[self.layout.rows(i)] for i in range(self.layout.n)}
        B, prior = self.B.beside(more, C.shape[1]), np.append(self.prior, np.zeros(C.shape[1]))
        held = np.pad(self.firm, (0, C.shape[1]))
        doubt = np.append(self.doubt, np.ones(C.shape[1]))
        return replace(self, B=B, prior=prior, doubt=doubt, known=(whole, right), held=held)

    def spread(self, columns: Columns) -> Array:
        """Columns (R, k) of all rows."""
        if columns.axis is None:
            return columns.values
        full = np.zeros((len(self.y), columns.values.shape[1]))
        full[self.layout.rows(columns.axis)] = columns.values
        return full

    def products(self, axis: int | None, C: Array) -> tuple[Array, Array, Array]:
        """(C between passes, B^T C (nb, k), C^T residual (k,)) for columns on an axis."""
        across = self.layout.across(C, axis)
        other = C if self.drifting else across
        return other, self.pulled(across, axis), other.T @ self.residual[self.layout.rows(axis)]

    def falls(self, axis: int | None, C: Array, k: int) -> Array:
        """Falls of the sum of squares for candidates of k neighbouring columns each.

        0 for candidates with columns that hardly repeat between passes.
        """
        beside = self._beside(Columns(axis, C))
        falls = []
        for at in range(0, C.shape[1], k):
            part = slice(at, at + k)
            S, c = beside.gram[part, part], beside.c[part]
            falls.append(0.0 if beside.lost[part].any() else c @ np.linalg.solve(S, c))
        return np.array(falls)

    def fall(self, columns: Columns) -> tuple[float, Array]:
        """Fall of the sum of squares by columns fitted beside the base, and their gains (k,); none
        by columns that hardly repeat between passes."""
        beside = self._beside(columns)
        beta = np.linalg.solve(beside.gram, beside.c)
        return float(beside.c @ beta), np.asarray(beta)

    def together(self, columns: Columns) -> tuple[Array, Array]:
        """Gains (k,) of columns and the base coefficients (nb,) beside them: of columns that the
        base has, too, the base's take all."""
        beside = self._beside(columns)
        beta = np.linalg.solve(beside.gram, beside.c)
        return np.asarray(beta), np.asarray(self.q - beside.moved @ beta)

    def _beside(self, columns: Columns) -> Beside:
        """Columns beside the base model."""
        axis, C = columns.axis, columns.values
        twin, cross, c = self.products(axis, C)
        moved, own = self.solve(cross), twin.T @ C
        there = self.times(moved) if axis is None else self.B.times(axis, moved)
        S, within = own - cross.T @ moved, (C**2).sum(axis=0)
        lost = is_gone(S, within, ((C - there) ** 2).sum(axis=0))
        return Beside(twin, c, moved, safe_gram(S, within, lost), lost)

    def gain(self, columns: Columns, changes: Array | None = None) -> GainEstimate:
        """Gains of columns beside the base model, and their cluster-robust covariance; changes
        (R, r): of what the columns explain by one standard deviation of other values that they
        depend on. What is known of parameters counts as rows."""
        beside = self._beside(columns)
        beta = np.asarray(np.linalg.solve(beside.gram, beside.c), dtype=float)
        known = -np.sqrt(self.prior * self.doubt)[:, None] * beside.moved
        scores, count = np.zeros((self.clusters, len(beta))), self.clusters
        by_changes = np.zeros((0 if changes is None else changes.shape[1], len(beta)))
        for i in range(self.layout.n):
            # columns without what the base explains, and those of the other pass
            there = self.layout.rows(i)
            clean = -self.B.times(i, beside.moved)
            other = self.layout.across(clean, i)
            if columns.axis in (None, i):
                place = there if columns.axis is None else slice(None)
                clean += columns.values[place]
                other += beside.twin[place]
            left, cluster = self.residual[there] - clean @ beta, self.layout.cluster[there]
            for k, values in enumerate(other.T):
                scores[:, k] += np.bincount(cluster, weights=left * values, minlength=count)
            if changes is not None:
                by_changes += changes[there].T @ other
        A, ideas = inverted(beside.gram), np.vstack([known, by_changes])
        factor = count / max(1, count - 1)
        covariance = A @ (factor * scores.T @ scores + ideas.T @ ideas) @ A
        return GainEstimate(beta, np.asarray(covariance), beside.lost, beside.gram)

    @property
    def strain(self) -> float:
        """Sum of squares of the parameters' deviations from what is known of them."""
        return float((self.prior * self.q**2).sum())

    @cached_property
    def clusters(self) -> int:
        """Largest number of a cluster, plus one."""
        return int(self.layout.cluster.max()) + 1

"""Products between passes of the base model's columns and of accepted terms, for each fold."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import LinAlgError, cho_factor, cho_solve

from flexhex.diagnosis.selection.rows import Rows

Array = NDArray[np.float64]
Left = int | None
"""Fold that is left out of a fit; None: none is."""
FIRM, UNSURE = 1e-8, 1e-6
"""Least curvature, relative to a column's own: added everywhere, so that rounding decides nothing;
and where noise made products between passes negative."""


@dataclass(frozen=True, eq=False)
class Term:
    """Columns (R, k) beside the base model on each axis that feels them, with the inverse
    variance (k,) of their coefficients: zero for free ones."""

    raw: dict[int, Array]
    white: dict[int, Array]
    prior: Array


@dataclass(frozen=True)
class Solved:
    """A fit: coefficients q (m,), and (G + prior)^-1 applied to right-hand sides."""

    q: Array
    solve: Callable[[Array], Array]


class Moments:
    """The base model with accepted terms: y = X c, c (m,) the base's and the terms' columns.

    freed: inverse variances of base parameters that left their tolerances, by their place.
    """

    def __init__(
        self,
        rows: Rows,
        terms: Sequence[Term] = (),
        freed: Mapping[int, float] = MappingProxyType({}),
    ) -> None:
        self.rows, self.terms, self.freed = rows, tuple(terms), freed
        widths = [len(term.prior) for term in terms]
        self.m = rows.nb + sum(widths)
        self.X = [self._beside(i, rows.B[i], [t.raw for t in terms]) for i in range(rows.n)]
        white = [t.white for t in terms]
        self.white_X = [self._beside(i, rows.white_B[i], white) for i in range(rows.n)]
        twin = [{i: np.asarray(rows.twins @ w) for i, w in own.items()} for own in white]
        self.twin_X = [self._beside(i, rows.twin_B[i], twin) for i in range(rows.n)]
        prior = rows.prior.copy()
        prior[list(freed)] = list(freed.values())
        self.prior = np.concatenate([prior, *(t.prior for t in terms)])
        self.fits: dict[Left, Solved] = {}
        self._grams: dict[int, tuple[Array, Array]] = {}

    def _beside(self, axis: int, base: Array, columns: Sequence[dict[int, Array]]) -> Array:
        if not columns:
            return base
        widths = [len(term.prior) for term in self.terms]
        empty = [np.zeros((len(base), w)) for w in widths]
        pairs = zip(columns, empty, strict=True)
        return np.hstack([base, *(own.get(axis, zero) for own, zero in pairs)])

    def extended(self, term: Term) -> Moments:
        """With one more term; products that are known already are kept."""
        longer = Moments(self.rows, (*self.terms, term), self.freed)
        for fold, (G, b) in self._grams.items():
            part, m = self.rows.parts[fold], self.m
            whole, right = np.zeros((longer.m, longer.m)), np.zeros(longer.m)
            whole[:m, :m], right[:m] = G, b
            for i, own in term.white.items():
                whole[:, m:] += longer.twin_X[i][part].T @ own[part]
                right[m:] += own[part].T @ self.rows.twin_y[i][part]
            whole[m:, :m] = whole[:m, m:].T
            whole[m:, m:] = (whole[m:, m:] + whole[m:, m:].T) / 2
            longer._grams[fold] = whole, right
        return longer

    def without(self, term: Term) -> Moments:
        """Without one of its terms; products that are known already are kept."""
        place = next(k for k, t in enumerate(self.terms) if t is term)
        start = self.rows.nb + sum(len(t.prior) for t in self.terms[:place])
        kept = np.delete(np.arange(self.m), np.s_[start : start + len(term.prior)])
        shorter = Moments(self.rows, [t for t in self.terms if t is not term], self.freed)
        shorter._grams = {f: (G[np.ix_(kept, kept)], b[kept]) for f, (G, b) in self._grams.items()}
        return shorter

    def loosened(self, places: Sequence[int], prior: float) -> Moments:
        """With another inverse variance of base parameters."""
        freed = {**self.freed, **dict.fromkeys(places, prior)}
        looser = Moments(self.rows, self.terms, freed)
        looser._grams = self._grams
        return looser

    def grams(self, fold: int) -> tuple[Array, Array]:
        """X^T X (m, m) and X^T y (m,) of a fold, whitened, between passes."""
        if fold not in self._grams:
            part = self.rows.parts[fold]
            G, b = np.zeros((self.m, self.m)), np.zeros(self.m)
            for X, twin, y in zip(self.white_X, self.twin_X, self.rows.white_y, strict=True):
                G += twin[part].T @ X[part]
                b += twin[part].T @ y[part]
            self._grams[fold] = (G + G.T) / 2, b
        return self._grams[fold]

    def gram(self, left: Left) -> tuple[Array, Array]:
        """The same of all folds but one."""
        listed = [self.grams(fold) for fold in self.rows.folds if fold != left]
        return sum(G for G, _ in listed), sum(b for _, b in listed)  # type: ignore[return-value]

    def fit(self, left: Left) -> Solved:
        """The fit to all folds but one."""
        if left not in self.fits:
            G, b = self.gram(left)
            solve = _solver(G, self.prior)
            self.fits[left] = Solved(solve(b), solve)
        return self.fits[left]


def _solver(G: Array, prior: Array) -> Callable[[Array], Array]:
    """(G + prior)^-1 as a function; directions that nothing determines stay where they are."""
    own = np.abs(np.diag(G) + prior)
    size = np.sqrt(np.where(own > 0, own, 1.0))
    scaled = (G + np.diag(prior)) / np.outer(size, size)
    scaled[np.diag_indices_from(scaled)] += FIRM
    try:
        factor = cho_factor(scaled)
    except LinAlgError:
        # products between passes of what hardly repeats may be negative
        values, vectors = np.linalg.eigh(scaled)
        factor = cho_factor((vectors * np.maximum(values, UNSURE)) @ vectors.T)

    def solve(right: Array) -> Array:
        across = size if right.ndim == 1 else size[:, None]
        return np.asarray(cho_solve(factor, right / across) / across)

    return solve

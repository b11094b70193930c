"""Products of the base model's columns and of accepted terms with each other, for each fold.

Between passes: of each instant's row in one pass with that in another, so that noise of angles and
torques, also what feedback makes of it, is no part of them. Within passes: what the model takes up
of a further column, with all that moves it.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.regression.design import Design, Stacked
from flexhex.diagnosis.selection.rows import Rows
from flexhex.diagnosis.selection.solved import Factor, Solved, factor_of

Array = NDArray[np.float64]
Left = int | None
"""Fold that is left out of a fit; None: none is."""


@dataclass(frozen=True, eq=False)
class Term:
    """Columns (R, k) beside the base model on each axis that feels them, as they are and whitened,
    with the inverse variance (k,) of their coefficients: zero for free ones."""

    raw: Mapping[int, Array]
    white: Mapping[int, Array]
    prior: Array


class Moments:
    """The base model with accepted terms: y = X c, c (m,) the base's and the terms' columns.

    freed: inverse variances of base parameters that left their tolerances, by their place; tight:
    how many times the inverse variances of a term are its own.
    """

    def __init__(
        self,
        rows: Rows,
        terms: Sequence[Term] = (),
        freed: Mapping[int, float] = MappingProxyType({}),
        tight: Mapping[Term, float] = MappingProxyType({}),
    ) -> None:
        self.rows, self.terms, self.freed, self.tight = rows, tuple(terms), freed, tight
        ends = rows.nb + np.cumsum([0, *(len(term.prior) for term in terms)])
        self._places = [slice(a, b) for a, b in itertools.pairwise(ends)]
        self.m = int(ends[-1])
        prior, places = rows.prior.copy(), list(freed)
        prior[places] = np.array(list(freed.values())) * rows.doubt[places]
        self.prior = np.concatenate([prior, *(t.prior * tight.get(t, 1.0) for t in terms)])
        self.fits: dict[Left, Solved] = {}
        self._within: dict[Left, Factor] = {}
        self._grams: dict[int, tuple[Array, Array]] = {}
        self._squares: dict[int, Array] = {}  # of the first columns, as far as they were asked for
        self._twins: dict[Term, Mapping[int, Array]] = {}
        self._left_over: dict[tuple[int, Left], tuple[float, float]] = {}
        self._most: dict[Left, float] = {}

    def sizes(self, c: Array) -> Array:
        """RMS of X c on each axis (n,) [N m]."""
        squares = [float(c @ self._square(i) @ c) for i in range(self.rows.n)]
        return np.sqrt(np.maximum(squares, 0.0) / self.rows.count)

    def _square(self, axis: int) -> Array:
        """X^T X (m, m) of an axis, not whitened, of all rows."""
        square = self._squares.get(axis, self.rows.squares[axis])
        for k, place in enumerate(self._places):
            if len(square) < place.stop:
                square = self._wider(square, axis, k)
        self._squares[axis] = square
        return square

    def _wider(self, square: Array, axis: int, k: int) -> Array:
        """X^T X of an axis with the columns of the k-th term, from that of all before it."""
        m, place = len(square), self._places[k]
        wider = np.zeros((place.stop, place.stop))
        wider[:m, :m] = square
        term = self.terms[k].raw.get(axis)
        if term is not None:
            wider[: self.rows.nb, place] = self.rows.B.pulled(axis, term)
            for other, beside in zip(self.terms[: k + 1], self._places, strict=False):
                if axis in other.raw:
                    wider[beside, place] = other.raw[axis].T @ term
            wider[place, :m] = wider[:m, place].T
        return wider

    def torque(self, axis: int, c: Array) -> Array:
        """X c (R,) of an axis [N m]."""
        return self._times(axis, c, self.rows.B, [t.raw.get(axis) for t in self.terms])

    def white(self, axis: int, c: Array) -> Array:
        """The same whitened."""
        return self._times(axis, c, self.rows.white_B, [t.white.get(axis) for t in self.terms])

    def _times(
        self, axis: int, c: Array, base: Design | Stacked, terms: Sequence[Array | None]
    ) -> Array:
        product = base.times(axis, c[: self.rows.nb])
        for own, place in zip(terms, self._places, strict=True):
            if own is not None:
                product += own @ c[place]
        return np.asarray(product)

    def pulled(self, values: Mapping[int, Array], fold: Left = None) -> Array:
        """X^T values (m, ...) of values (R, ...) on these axes, in all rows or those of a fold,
        which values are of then."""
        part = slice(None) if fold is None else self.rows.parts[fold]
        products = np.zeros((self.m, *next(iter(values.values())).shape[1:]))
        for i, v in values.items():
            products[: self.rows.nb] += self.rows.white_B.pulled(i, v, part)
            for term, place in zip(self.terms, self._places, strict=True):
                if i in term.white:
                    products[place] += term.white[i][part].T @ v
        return products

    def extended(self, term: Term) -> Moments:
        """With one more term; products that are known already are kept."""
        longer = Moments(self.rows, (*self.terms, term), self.freed, self.tight)
        longer._twins = dict(self._twins)
        for fold in self.rows.folds:
            (G, b), part, m = self.grams(fold), self.rows.parts[fold], self.m
            both = longer.both(term)
            whole, right = np.zeros((len(both), longer.m, longer.m)), np.zeros(longer.m)
            whole[:, :m, :m], right[:m] = G, b
            for own, columns in zip(whole, both, strict=True):
                there = {i: white[part] for i, white in columns.items()}
                own[:, m:] = longer.pulled(there, fold)
                own[m:, :m] = own[:m, m:].T
                own[m:, m:] = (own[m:, m:] + own[m:, m:].T) / 2
            right[m:] = sum(w[part].T @ self.rows.white_y[i][part] for i, w in both[0].items())
            longer._grams[fold] = whole, right
        longer._squares = dict(self._squares)
        return longer

    def without(self, *terms: Term) -> Moments:
        """Without some of its terms; products that are known already are kept."""
        if not terms:
            return self
        gone = np.concatenate([np.arange(self.m)[self.place(term)] for term in terms])
        kept = np.setdiff1d(np.arange(self.m), gone)
        left = [t for t in self.terms if t not in terms]
        shorter = Moments(self.rows, left, self.freed, self.tight)
        shorter._twins = {t: own for t, own in self._twins.items() if t in shorter.terms}
        own = np.ix_(kept, kept)
        shorter._grams = {f: (G[:, own[0], own[1]], b[kept]) for f, (G, b) in self._grams.items()}
        whole = {i: square for i, square in self._squares.items() if len(square) == self.m}
        shorter._squares = {i: square[own] for i, square in whole.items()}
        return shorter

    def both(self, term: Term) -> list[Mapping[int, Array]]:
        """Whitened columns (R, k) of a term, of each axis: as the other passes have them, and, if
        there are any, as they are."""
        if not self.rows.repeated:
            return [term.white]
        if term not in self._twins:
            self._twins[term] = {i: self.rows.across(white) for i, white in term.white.items()}
        return [self._twins[term], term.white]

    def place(self, term: Term) -> slice:
        """Where the columns of a term stand."""
        return self._places[next(k for k, t in enumerate(self.terms) if t is term)]

    def loosened(self, places: Sequence[int], prior: float) -> Moments:
        """With another inverse variance of base parameters."""
        return self._again({**self.freed, **dict.fromkeys(places, prior)}, self.tight)

    def tightened(self, tight: Mapping[Term, float]) -> Moments:
        """With the inverse variances of terms times so much."""
        return self._again(self.freed, tight)

    def _again(self, freed: Mapping[int, float], tight: Mapping[Term, float]) -> Moments:
        """The same products beside another prior."""
        other = Moments(self.rows, self.terms, freed, tight)
        other._grams, other._twins, other._squares = self._grams, self._twins, self._squares
        return other

    def grams(self, fold: int) -> tuple[Array, Array]:
        """X^T X (ways, m, m) of a fold, whitened, see `Rows.ways`, and X^T y (m,) between passes;
        of a model with terms they are known."""
        if not self._grams:
            self._grams = self._products()
        return self._grams[fold]

    def _products(self) -> dict[int, tuple[Array, Array]]:
        rows, count = self.rows, 1 + self.rows.repeated
        products = {f: (np.zeros((count, self.m, self.m)), np.zeros(self.m)) for f in rows.folds}
        for i in range(rows.n):
            for places, values in rows.white_B.pieces[i]:
                ways = rows.ways(values)
                for fold, (G, b) in products.items():
                    part = rows.parts[fold]
                    for own, columns in zip(G, ways, strict=True):
                        own[:, places] += rows.white_B.pulled(i, columns[part], part)
                    b[places] += ways[0][part].T @ rows.white_y[i][part]
        return {fold: ((G + G.swapaxes(1, 2)) / 2, b) for fold, (G, b) in products.items()}

    def gram(self, left: Left) -> tuple[Array, Array]:
        """X^T X (m, m) and X^T y (m,) between passes, of all folds but one."""
        listed = [self.grams(fold) for fold in self.rows.folds if fold != left]
        return sum(G[0] for G, _ in listed), sum(b for _, b in listed)  # type: ignore[return-value]

    def left_over(self, axis: int, left: Left) -> tuple[float, float]:
        """Sum of squares of the whitened torque of an axis, and of what the fit to all folds but
        one leaves of it there beyond noise: between passes, or less the noise's own."""
        if (axis, left) not in self._left_over:
            rows, kept = self.rows, self.rows.fold != left
            rest = rows.white_y[axis] - self.white(axis, self.fit(left).q)
            pairs = (rows.white_y[axis], rows.twin_y[axis]), (rest, rows.across(rest))
            whole, unexplained = (float(one[kept] @ other[kept]) for one, other in pairs)
            noise = 0.0 if rows.model.between else float(kept.sum())
            self._left_over[axis, left] = whole, unexplained - noise
        return self._left_over[axis, left]

    def most(self, left: Left) -> float:
        """Squares that more columns can take from the fit to all folds but one: those of all that
        it leaves, noise and what differs between passes among them, and of how far parameters are
        off in tolerances, which may be in their place."""
        if left not in self._most:
            rows, q = self.rows, self.fit(left).q
            kept = rows.fold != left
            rests = (rows.white_y[i] - self.white(i, q) for i in range(rows.n))
            base = q[: rows.nb]
            strain = float(self.prior @ q**2 + base @ rows.firm @ base)
            self._most[left] = strain + sum(float(rest[kept] @ rest[kept]) for rest in rests)
        return self._most[left]

    def fit(self, left: Left) -> Solved:
        """The fit to all folds but one."""
        if left not in self.fits:
            G, b = self.gram(left)
            G[: self.rows.nb, : self.rows.nb] += self.rows.firm
            self.fits[left] = Solved.of(factor_of(G, self.prior), b)
        return self.fits[left]

    def within(self, left: Left) -> Factor:
        """Of products within passes, of all folds but one: what the model takes up of a column's
        own square."""
        if not self.rows.repeated:
            return self.fit(left)
        if left not in self._within:
            G = sum(self.grams(fold)[0][-1] for fold in self.rows.folds if fold != left)
            self._within[left] = factor_of(np.asarray(G), self.prior)
        return self._within[left]

"""The columns of a linear model, axis by axis, without those that are zero on an axis.

Most parameters of a machine act on some axes alone: kept whole, half of all columns are zeros.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Index = NDArray[np.int64]
RowSelection = slice | Index
ALL = slice(None)


@dataclass(frozen=True, eq=False)
class Design:
    """Columns X (R, width) of the rows of each axis: of each some places (k,) and what stands there
    (R, k), which may come in several pieces."""

    width: int
    pieces: tuple[tuple[tuple[Index, Array], ...], ...]

    @staticmethod
    def of(columns: Sequence[Array]) -> Design:
        """Of whole columns (R, width) of each axis."""
        places = [np.flatnonzero(values.any(axis=0)) for values in columns]
        pieces = zip(places, columns, strict=True)
        return Design(columns[0].shape[1], tuple(((p, v[:, p]),) for p, v in pieces))

    def beside(self, more: Mapping[int, Array], count: int) -> Design:
        """With `count` further columns, of some axes."""
        places = self.width + np.arange(count)
        own = (((places, more[i]),) if i in more else () for i in range(len(self.pieces)))
        pairs = zip(self.pieces, own, strict=True)
        return Design(self.width + count, tuple((*listed, *new) for listed, new in pairs))

    def only(self, kept: Index) -> Design:
        """Some of the columns, in their order."""
        chosen = []
        for listed in self.pieces:
            own = [(np.searchsorted(kept, p), np.isin(p, kept), v) for p, v in listed]
            chosen.append(tuple((at[there], v[:, there]) for at, there, v in own))
        return Design(len(kept), tuple(chosen))

    def whole(self, axis: int) -> Array:
        """X (R, width) of an axis."""
        return self.at(axis, np.arange(self.width))

    def at(self, axis: int, places: Index) -> Array:
        """X (R, len(places)) of an axis at some places, in their order."""
        order = np.full(self.width, -1)
        order[places] = np.arange(len(places))
        columns = np.zeros((self.rows(axis), len(places)))
        for own, values in self.pieces[axis]:
            there = order[own] >= 0
            columns[:, order[own[there]]] = values[:, there]
        return columns

    def places(self, axis: int) -> Index:
        """Places of the columns that an axis has."""
        return np.concatenate([places for places, _ in self.pieces[axis]])

    def rows(self, axis: int) -> int:
        """Rows of an axis."""
        return len(self.pieces[axis][0][1])

    def times(self, axis: int, q: Array) -> Array:
        """X q (R, ...) of an axis, q (width, ...)."""
        first, *others = [_product(values, q[places]) for places, values in self.pieces[axis]]
        for other in others:
            first += other
        return np.asarray(first)

    def pulled(self, axis: int, values: Array, part: RowSelection = ALL) -> Array:
        """X^T values (width, ...) of some rows of an axis."""
        products = np.zeros((self.width, *values.shape[1:]))
        for places, own in self.pieces[axis]:
            products[places] = _product(own[part].T, values)
        return products

    def squares(self, axis: int) -> Array:
        """X^T X (width, width) of an axis."""
        products = np.zeros((self.width, self.width))
        for place, own in self.pieces[axis]:
            for beside, other in self.pieces[axis]:
                products[np.ix_(place, beside)] = own.T @ other
        return products


@dataclass(frozen=True, eq=False)
class Stacked:
    """Columns X (R, width) of the rows that count, kept (m,), of several designs one below the
    other, without a copy of them."""

    designs: Sequence[Design]
    kept: Sequence[NDArray[np.bool_]]

    def only(self, places: Index) -> Stacked:
        """Some of the columns, in their order."""
        return Stacked([design.only(places) for design in self.designs], self.kept)

    def at(self, axis: int, places: Index) -> Array:
        """X (R, len(places)) of an axis at some places, in their order."""
        pairs = zip(self.designs, self.kept, strict=True)
        return np.concatenate([design.at(axis, places)[kept] for design, kept in pairs])

    def times(self, axis: int, q: Array) -> Array:
        """X q (R, ...) of an axis, q (width, ...)."""
        pairs = zip(self.designs, self.kept, strict=True)
        return np.concatenate([design.times(axis, q)[kept] for design, kept in pairs])

    def pulled(self, axis: int, values: Array) -> Array:
        """X^T values (width, ...) of the rows of an axis."""
        products, first = np.zeros((self.designs[0].width, *values.shape[1:])), 0
        for design, kept in zip(self.designs, self.kept, strict=True):
            own = np.zeros((len(kept), *values.shape[1:]))
            end = first + int(kept.sum())
            own[kept], first = values[first:end], end
            products += design.pulled(axis, own)
        return products

    def squares(self, axis: int) -> Array:
        """X^T X (width, width) of an axis."""
        squares = np.zeros((self.designs[0].width,) * 2)
        for design, kept in zip(self.designs, self.kept, strict=True):
            pieces = tuple((places, values[kept]) for places, values in design.pieces[axis])
            squares += Design(design.width, (pieces,)).squares(0)
        return squares


def _product(many: Array, few: Array) -> Array:
    """many @ few, (a, b) by (b[, k]): of few columns k this order takes BLAS half as long."""
    return (few.T @ many.T).T


def beside_of(design: Design, columns: Array) -> Design:
    """With further columns (R, n, k) of all axes; those that are zero on an axis are left out."""
    own = Design.of([columns[:, i] for i in range(columns.shape[1])])
    shifted = [((design.width + p, v),) for ((p, v),) in own.pieces]
    pieces = tuple((*a, *b) for a, b in zip(design.pieces, shifted, strict=True))
    return Design(design.width + own.width, pieces)

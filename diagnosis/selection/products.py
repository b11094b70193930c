"""Products of an effect's columns with a model's, fold by fold."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.selection.moments import Left, Term

Array = NDArray[np.float64]
GONE = 1e-5
"""Share of a column's square below which the base model explains all of it."""
STEADY = 0.8
"""Least share of what is left of a column's squares within passes that counts as common to them.
With 0.5 and 0.9 three measured robots and a cubic spring of loose feedback end the same."""


@dataclass(frozen=True)
class Products:
    """Of each fold, of whitened columns with a model's (folds, m, shapes * k), with the torque
    (folds, shapes * k) and with each other (folds, shapes, k, k), within and between passes."""

    folds: Sequence[int]
    cross: Array
    right: Array
    own: Array
    between: Array

    def without(self, left: Left) -> tuple[Array, ...]:
        """Sums of all folds but one."""
        if left is None:
            return self.whole
        fold = self.folds.index(left)
        return tuple(all_ - each[fold] for all_, each in zip(self.whole, self._each, strict=True))

    @cached_property
    def whole(self) -> tuple[Array, ...]:
        """Sums of all folds."""
        return tuple(each.sum(axis=0) for each in self._each)

    @property
    def _each(self) -> tuple[Array, ...]:
        return self.cross, self.right, self.own, self.between


@dataclass(eq=False)
class ShapeProducts:
    """Products of the columns of one shape that are known already: with the base model's columns,
    with the torque, with each other within and between passes, of each fold; with those of each
    term (folds, k', k)."""

    base: tuple[Array, ...] | None = None
    terms: WeakKeyDictionary[Term, Array] = field(default_factory=WeakKeyDictionary)

    def forget(self) -> None:
        """Let go of them."""
        self.base = None
        self.terms.clear()


def placed(chosen: Sequence[int], width: int) -> Iterator[tuple[slice, int, int]]:
    """Where the columns of some shapes stand side by side, their number there and their place."""
    return ((slice(j * width, (j + 1) * width), j, s) for j, s in enumerate(chosen))


def common(within: Array, between: Array) -> Array:
    """Products of columns (..., k, k) that passes have in common: those between them, but at least
    `STEADY` of those within. Passes that moved otherwise differ in their columns; of a column that
    is noise they have next to nothing in common, and any chance would be large beside that."""
    size, ways = np.linalg.eigh(within)
    size = np.sqrt(np.where(size > GONE * size[..., -1:], size, 0.0))
    scaled = ways / np.where(size > 0, size, np.inf)[..., None, :]
    values, vectors = np.linalg.eigh(scaled.swapaxes(-1, -2) @ between @ scaled)
    turned = (ways * size[..., None, :]) @ vectors
    kept = turned * np.clip(values, STEADY, 1.0)[..., None, :]
    return np.asarray(kept @ turned.swapaxes(-1, -2))

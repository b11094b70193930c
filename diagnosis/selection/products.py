"""Products of an effect's columns with a model's, fold by fold."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.selection.moments import Left, Term

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Products:
    """Of each fold, of whitened columns with a model's (ways, folds, m, shapes * k), between passes
    and within each, see `Rows.ways`; with the torque (folds, shapes * k), between passes; and with
    each other (folds, shapes, k, k), within each."""

    folds: Sequence[int]
    cross: Array
    right: Array
    own: Array

    def without(self, left: Left) -> tuple[Array, Array, Array]:
        """Sums of all folds but one."""
        if left is None:
            return self.whole
        fold = self.folds.index(left)
        cross, right, own = self.whole
        return cross - self.cross[:, fold], right - self.right[fold], own - self.own[fold]

    @cached_property
    def whole(self) -> tuple[Array, Array, Array]:
        """Sums of all folds."""
        return self.cross.sum(axis=1), self.right.sum(axis=0), self.own.sum(axis=0)


@dataclass(eq=False)
class ShapeProducts:
    """Products of the columns of one shape that are known already: with the base model's columns,
    with the torque, with each other, of each fold; with those of each term (ways, folds, k', k);
    and the share (R,) of a change of the reported torque that a gain of one takes away."""

    base: tuple[Array, Array, Array] | None = None
    terms: WeakKeyDictionary[Term, Array] = field(default_factory=WeakKeyDictionary)
    taken: Array | None = None

    def share(
        self, made: Callable[[Mapping[str, float]], Array], shape: Mapping[str, float]
    ) -> Array:
        """`taken` of a shape, made when it is asked for first."""
        if self.taken is None:
            self.taken = made(shape)
        return self.taken

    def forget(self) -> None:
        """Let go of them."""
        self.base = self.taken = None
        self.terms.clear()


def placed(chosen: Sequence[int], width: int) -> Iterator[tuple[slice, int, int]]:
    """Where the columns of some shapes stand side by side, their number there and their place."""
    return ((slice(j * width, (j + 1) * width), j, s) for j, s in enumerate(chosen))

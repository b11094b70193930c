"""Where the rows of a regression come from, and which rows of other passes are their twins."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True)
class Layout:
    """Where rows come from, axis by axis: axis, fold, cluster, partner (R,).

    fold: trajectories (or stretches of the only one) that arbitrate in turn; cluster: about a
    second of one trajectory, all axes and passes of it, within which errors go together.
    partner: the same axis and instant of another pass, or the row itself where there is none.
    """

    axis: Index
    fold: Index
    cluster: Index
    partner: Index

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

    @cached_property
    def mutual(self) -> bool:
        """Whether every row is its partner's partner: two passes, or none to compare with."""
        return bool((self.partner[self.partner] == np.arange(len(self.partner))).all())

    def twin(self, values: Array, axis: int | None = None) -> Array:
        """Rows (R, ...), or (R_i, ...) of an axis, as the other pass has them."""
        rows = self.rows(axis)
        first = (rows.start or 0) if len(values) < len(self.axis) else 0
        return np.asarray(values[self.partner[rows] - first])

"""Where the rows of a regression come from, and which rows of other passes are their twins."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

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
    def n(self) -> int:
        """Axes."""
        return int(self.axis[-1]) + 1

    def rows(self, axis: int | None) -> slice:
        """Rows of an axis; of all when it is None."""
        if axis is None:
            return slice(None)
        bounds = np.searchsorted(self.axis, [axis, axis + 1])
        return slice(int(bounds[0]), int(bounds[1]))

    def across(self, values: Array, axis: int | None = None) -> Array:
        """J values (R, ...), or (R_i, ...) of an axis: each row as other passes have it, symmetric
        in the passes. Without other passes the rows themselves."""
        return np.asarray(self.twins(axis) @ values)

    def twins(self, axis: int | None) -> csr_array:
        """J (R, R), or (R_i, R_i) of an axis."""
        if axis not in self._kept:
            rows = self.rows(axis)
            partner = self.partner[rows] - (rows.start or 0)
            count = len(partner)
            to = csr_array((np.ones(count), (np.arange(count), partner)), shape=(count, count))
            self._kept[axis] = csr_array((to + to.T) / 2)
        return self._kept[axis]

    @cached_property
    def _kept(self) -> dict[int | None, csr_array]:
        return {}

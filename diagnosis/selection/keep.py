"""Columns that are expensive to make, kept as long as there is room."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
ROOM = 600_000_000
"""Room for columns [bytes]."""


class Keep:
    """Columns by key and axis, those that were asked for last. They are kept in half the digits: a
    rounding of 1e-7 is far below what the base model leaves of any column that counts."""

    def __init__(self, room: int = ROOM) -> None:
        self.room, self.taken = room, 0
        self._columns: dict[Hashable, dict[int, NDArray[np.float32]]] = {}  # (k, R)

    def __contains__(self, key: Hashable) -> bool:
        return key in self._columns

    def add(self, key: Hashable, axis: int, columns: Array) -> None:
        """Keep columns (R, k) of an axis."""
        short = np.ascontiguousarray(columns.T, dtype=np.float32)
        self._columns.setdefault(key, {})[axis] = short
        self.taken += short.nbytes

    def forget(self) -> None:
        """Let go of all columns."""
        self._columns.clear()
        self.taken = 0

    def side_by_side(self, keys: Sequence[Hashable]) -> Mapping[int, Array]:
        """Columns (R, keys * k) of each axis, of keys that are kept; then what was asked for
        longest ago makes room."""
        parts = [self._columns[key] for key in keys]
        for key in dict.fromkeys(keys):
            self._columns[key] = self._columns.pop(key)
        stacked = {i: np.vstack([p[i] for p in parts], dtype=np.float64).T for i in parts[0]}
        while self.taken > self.room and len(self._columns) > 1:
            self.taken -= sum(
                v.nbytes for v in self._columns.pop(next(iter(self._columns))).values()
            )
        return stacked

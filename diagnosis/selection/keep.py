"""Columns that are expensive to make, kept as long as there is room."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.selection.hypothesis import Columns

ROOM = 300_000_000
"""Room for columns [bytes]."""


class Keep:
    """The columns that were asked for last. They are kept in half the digits: a rounding of 1e-7 is
    far below what the base model leaves of any column that counts."""

    def __init__(self, room: int = ROOM) -> None:
        self.room, self.taken = room, 0
        self._found: dict[Hashable, tuple[Mapping[int, NDArray[np.float32]], ...]] = {}

    def columns(self, key: Hashable, make: Callable[[], Columns]) -> Columns:
        """Columns of a key; `make` makes them if they are not kept."""
        short = self._found.pop(key, None)
        if short is None:
            made = make()
            short = tuple(
                {i: v.astype(np.float32) for i, v in part.items()}
                for part in (made.raw, made.white)
            )
            self.taken += size_of(short)
        self._found[key] = short
        while self.taken > self.room and len(self._found) > 1:
            self.taken -= size_of(self._found.pop(next(iter(self._found))))
        raw, white = ({i: v.astype(np.float64) for i, v in part.items()} for part in short)
        return Columns(raw, white)


def size_of(parts: tuple[Mapping[int, NDArray[np.float32]], ...]) -> int:
    """Bytes."""
    return sum(v.nbytes for part in parts for v in part.values())

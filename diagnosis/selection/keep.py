"""Columns that are expensive to make, kept as long as there is room."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
ROOM = 300_000_000
"""Room for columns [bytes]. Fits before and after a search take more memory; a search that has to
make its columns again takes longer."""


@dataclass(frozen=True, eq=False)
class _Block:
    """Columns (R, keys * k) of each axis that were made together, and mostly are asked for so."""

    keys: Sequence[Hashable]
    columns: Mapping[int, NDArray[np.float32]]

    @property
    def nbytes(self) -> int:
        """Memory that it takes [bytes]."""
        return sum(v.nbytes for v in self.columns.values())

    def part(self, axis: int, first: int, end: int) -> NDArray[np.float32]:
        """Columns of an axis of some neighbouring keys."""
        columns = self.columns[axis]
        k = columns.shape[1] // len(self.keys)
        return columns[:, first * k : end * k]


class Keep:
    """Columns by key and axis, those that were asked for last. They are kept in half the digits: a
    rounding of 1e-7 is far below what the base model leaves of any column that counts."""

    def __init__(self, room: int = ROOM) -> None:
        self.room, self.taken = room, 0
        self._places: dict[Hashable, tuple[_Block, int]] = {}
        self._blocks: dict[_Block, None] = {}

    def __contains__(self, key: Hashable) -> bool:
        return key in self._places

    def add(self, keys: Sequence[Hashable], columns: Mapping[int, Array]) -> None:
        """Keep columns (R, keys * k) of each axis that feels them."""
        block = _Block(keys, {i: v.astype(np.float32) for i, v in columns.items()})
        self._blocks[block] = None
        self._places |= {key: (block, place) for place, key in enumerate(keys)}
        self.taken += block.nbytes

    def forget(self) -> None:
        """Let go of all columns."""
        self._places.clear()
        self._blocks.clear()
        self.taken = 0

    def side_by_side(self, keys: Sequence[Hashable]) -> Mapping[int, Array]:
        """Columns (R, keys * k) of each axis, of keys that are kept; then what was asked for
        longest ago makes room."""
        pieces = list[tuple[_Block, int, int]]()
        for block, place in (self._places[key] for key in keys):
            first = pieces.pop()[1] if pieces and pieces[-1][::2] == (block, place) else place
            pieces.append((block, first, place + 1))
        for block, *_ in pieces:
            self._blocks[block] = self._blocks.pop(block)
        stacked = {
            i: np.hstack([block.part(i, *span) for block, *span in pieces], dtype=np.float64)
            for i in pieces[0][0].columns
        }
        while self.taken > self.room and len(self._blocks) > 1:
            oldest = next(iter(self._blocks))
            del self._blocks[oldest]
            self.taken -= oldest.nbytes
            for key in oldest.keys:
                del self._places[key]
        return stacked

"""The base model's columns along a run, without those that are zero on an axis: half of all are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Known

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Pieces = tuple[tuple[Index, Array], ...]
"""Places (k,) of some columns and their values (m, k)."""
ALL = slice(None)


@dataclass(frozen=True, eq=False)
class Linear:
    """Columns of each axis, for coefficients in units (n_p,) of the parameters' tolerances, or one
    where that is none: models that are fitted to a run share them."""

    unit: Array
    pieces: tuple[Pieces, ...]

    @staticmethod
    def of(rows: Array, known: Sequence[Known]) -> Linear:
        """Of columns (m, n, n_p) per unit of each parameter."""
        tolerance = np.array([k.tolerance for k in known])
        free = tolerance > 0
        unit = np.where(free & np.isfinite(tolerance), tolerance, 1.0)
        pieces = []
        for i in range(rows.shape[1]):
            there = rows[:, i].any(axis=0)
            parts = [np.flatnonzero(there & some) for some in (free, ~free)]
            parts = [part for k, part in enumerate(parts) if len(part) or not k]
            pieces.append(tuple((part, rows[:, i, part] * unit[part]) for part in parts))
        return Linear(unit, tuple(pieces))

    def scaled(self, scale: Array) -> tuple[Pieces, ...]:
        """Columns of each axis for coefficients in other units (n_p,), the same arrays where these
        are the same; none of those that have a unit of zero."""
        ratio, scaled = scale / self.unit, list[Pieces]()
        for own in self.pieces:
            kept = [(ratio[places] != 0, places, values) for places, values in own]
            listed = [
                (places, values)
                if (ratio[places] == 1).all()
                else (places[some], values[:, some] * ratio[places[some]])
                for some, places, values in kept
            ]
            scaled.append(tuple(listed))
        return tuple(scaled)

    def times(self, p: Array, part: slice = ALL) -> Array:
        """Torque (m, n) of parameters p (n_p,), in some rows."""
        q = p / self.unit
        each = [sum(values[part] @ q[places] for places, values in own) for own in self.pieces]
        return np.stack(each, axis=1)

    def at(self, places: Sequence[int], part: slice = ALL) -> Array:
        """Columns (m, n, len(places)) per unit of some parameters, in some rows."""
        rows, order = self.pieces[0][0][1][part], np.full(len(self.unit), -1)
        order[list(places)] = np.arange(len(places))
        columns = np.zeros((len(rows), len(self.pieces), len(places)))
        for i, own in enumerate(self.pieces):
            for there, values in own:
                some = order[there] >= 0
                here = there[some]
                columns[:, i, order[here]] = values[part][:, some] / self.unit[here]
        return columns

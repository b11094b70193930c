"""Rows of all runs, axis by axis and fold after fold: whitened ones for the fit, ones in N m for
the score."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, dia_array

from flexhex.diagnosis.calibrate import Calibrated

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True)
class Rows:
    """y[i] (R,) = B[i] (R, nb) q on each axis i [N m]; white_y, white_B: the same whitened.

    moving[i] (R,): 1 where the axis moves, 0 where it rests and a row says nothing. order (R,):
    places of the rows among those of the runs, fold after fold. fold (R,): trajectory, or stretch
    of an only one. twins (R, R): the mean of the same instant's other passes, symmetric and within
    a fold; a row that has none is its own. prior (nb,): inverse variance of q; torque_rms (n,)
    [N m].
    """

    made: Calibrated
    y: tuple[Array, ...]
    B: tuple[Array, ...]
    white_y: tuple[Array, ...]
    white_B: tuple[Array, ...]
    moving: tuple[Array, ...]
    order: Index
    fold: Index
    twins: csr_array
    prior: Array
    torque_rms: Array

    @staticmethod
    def of(made: Calibrated) -> Rows:
        """Rows of a calibrated base model."""
        layout, n = made.layout, made.base.n
        count = len(layout.axis) // n
        order = np.argsort(layout.fold[:count], kind="stable")
        partner = layout.partner[:count] if made.between else np.arange(count)
        to = csr_array((np.ones(count), (np.arange(count), partner)))
        prior = np.array([1.0 if np.isfinite(k.tolerance) else 0.0 for k in made.known])
        y, B = ([[v[:, i] for v in listed] for i in range(n)] for listed in (made.y, made.B))
        moving = [[v[:, i].astype(float) for v in made.moving] for i in range(n)]
        return Rows(
            made,
            tuple(kept(made, v)[order] for v in y),
            tuple(kept(made, v)[order] for v in B),
            tuple(made.white(i, v)[order, 0] for i, v in enumerate(y)),
            tuple(made.white(i, v)[order] for i, v in enumerate(B)),
            tuple(kept(made, v)[order] for v in moving),
            order,
            layout.fold[:count][order],
            csr_array((to + to.T) / 2)[order][:, order],
            prior,
            made.torque_rms,
        )

    @property
    def n(self) -> int:
        """Axes."""
        return len(self.y)

    @property
    def nb(self) -> int:
        """Columns of the base model."""
        return len(self.prior)

    @property
    def count(self) -> int:
        """Rows of an axis."""
        return len(self.fold)

    @cached_property
    def parts(self) -> dict[int, slice]:
        """Rows of each fold, by its number."""
        numbers, start = np.unique(self.fold, return_index=True)
        ends = [*start[1:], self.count]
        return {int(f): slice(int(a), int(b)) for f, a, b in zip(numbers, start, ends, strict=True)}

    @property
    def folds(self) -> list[int]:
        """Numbers of the folds."""
        return list(self.parts)

    @cached_property
    def pairs(self) -> csr_array:
        """`twins` without rows that are their own."""
        own = dia_array((self.twins.diagonal()[None], [0]), shape=self.twins.shape)
        found = csr_array(self.twins - own)
        found.eliminate_zeros()
        return found

    @cached_property
    def twin_B(self) -> list[Array]:
        """white_B as the other passes have it."""
        return [np.asarray(self.twins @ B) for B in self.white_B]

    @cached_property
    def squares(self) -> list[Array]:
        """B^T B (nb, nb) of each axis [N^2 m^2]."""
        return [B.T @ B for B in self.B]

    @cached_property
    def twin_y(self) -> list[Array]:
        """white_y as the other passes have it."""
        return [np.asarray(self.twins @ y) for y in self.white_y]

    @cached_property
    def white_rms(self) -> Array:
        """Torque RMS (n,) of each axis in units of its noise's innovations."""
        return np.asarray(self.torque_rms / self.made.noise.scale)

    @cached_property
    def _lines(self) -> list[tuple[Index, Array]]:
        """Of each run its rows and an orthonormal base (rows, 2) of straight lines along them."""
        counts = [int(good.sum()) for good in self.made.kept]
        run = np.repeat(np.arange(len(counts)), counts)[self.order]
        found = []
        for number in range(len(counts)):
            own = np.flatnonzero(run == number)
            line = np.stack([np.ones(len(own)), np.arange(len(own))], axis=1)
            found.append((own, np.linalg.qr(line)[0]))
        return found

    def level(self, values: Array) -> Array:
        """Values (R,) without a straight line through each run: offsets wander from run to run."""
        found = values.copy()
        for own, line in self._lines:
            found[own] -= line @ (line.T @ values[own])
        return found

    def raw(self, values: Sequence[Array]) -> Array:
        """Rows (R, ...) of values (m, ...) in each block."""
        return np.asarray(kept(self.made, values)[self.order])

    def white(self, axis: int, values: Sequence[Array]) -> Array:
        """Whitened rows (R, k) of values (m[, k]) of an axis in each block."""
        return np.asarray(self.made.white(axis, values)[self.order])


def kept(made: Calibrated, values: Sequence[Array]) -> Array:
    """Rows that count (R, ...) of values (m, ...) in each block."""
    return np.concatenate([v[good] for v, good in zip(values, made.kept, strict=True)])

"""Rows of all runs, axis by axis: whitened ones for the fit, ones in N m for the score."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, dia_array

from flexhex.diagnosis.regression.calibrate import Calibrated
from flexhex.diagnosis.regression.design import Design, RowSelection, Stacked
from flexhex.diagnosis.runs.noise import line

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True)
class Rows:
    """y[i] (R,) = B (R, nb) q on each axis i [N m]; white_y, white_B: the same whitened.

    moving[i] (R,): where the axis moves; where it rests a row says nothing. fold (R,):
    trajectory, or stretch of an only one. twins (R, R): the mean of the same instant's other
    passes, symmetric and within a fold; a row that has none is its own. prior (nb,): inverse
    variance of q, doubt (nb,) times; firm (nb, nb): curvature where noise alone moves B;
    torque_rms (n,) [N m].
    """

    model: Calibrated
    y: tuple[Array, ...]
    B: Design | Stacked
    white_y: tuple[Array, ...]
    white_B: Design
    moving: tuple[NDArray[np.bool_], ...]
    fold: Index
    twins: csr_array
    prior: Array
    doubt: Array
    firm: Array
    torque_rms: Array

    @staticmethod
    def of(model: Calibrated) -> Rows:
        """Rows of a calibrated base model."""
        layout, n, white = model.layout, model.base.n, model.regression
        own = layout.rows(0)
        twins = layout.twins(0)
        if not model.between:
            twins = csr_array(dia_array((np.ones(twins.shape[0])[None], [0]), shape=twins.shape))
        y = [[v[:, i] for v in model.y] for i in range(n)]
        moving = np.concatenate(model.moving)
        return Rows(
            model,
            tuple(kept(model, v) for v in y),
            model.kept_B,
            tuple(white.y[layout.rows(i)] for i in range(n)),
            white.B,
            tuple(moving.T),
            layout.fold[own],
            twins,
            white.prior,
            white.doubt,
            white.firm,
            model.torque_rms,
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

    def often(self, places: Sequence[int]) -> float:
        """How often rows say the same again of these base parameters together: at most as often as
        of the one of which they do most."""
        return float(self.doubt[list(places)].max())

    @cached_property
    def parts(self) -> dict[int, RowSelection]:
        """Rows of each fold, by its number."""
        parts = dict[int, RowSelection]()
        for number in np.unique(self.fold):
            rows = np.flatnonzero(self.fold == number)
            together = rows[-1] - rows[0] + 1 == len(rows)
            parts[int(number)] = slice(int(rows[0]), int(rows[-1]) + 1) if together else rows
        return parts

    @property
    def folds(self) -> list[int]:
        """Numbers of the folds."""
        return list(self.parts)

    @cached_property
    def pairs(self) -> csr_array:
        """`twins` without rows that are their own."""
        own = dia_array((self.twins.diagonal()[None], [0]), shape=self.twins.shape)
        others = csr_array(self.twins - own)
        others.eliminate_zeros()
        return others

    @cached_property
    def repeated(self) -> bool:
        """Whether any row has another pass."""
        return bool(self.pairs.nnz)

    def ways(self, values: Array) -> list[Array]:
        """Rows (R, ...) to take products with: as the other passes have them, for those between
        passes, and, if there are any, as they are, for those within passes."""
        return [self.across(values), values] if self.repeated else [values]

    def across(self, values: Array) -> Array:
        """Rows (R, ...) as the other passes have them."""
        return np.asarray(self.twins @ values)

    @cached_property
    def squares(self) -> list[Array]:
        """B^T B (nb, nb) of each axis [N^2 m^2]."""
        return [self.B.squares(i) for i in range(self.n)]

    @cached_property
    def twin_y(self) -> list[Array]:
        """white_y as the other passes have it."""
        return [self.across(y) for y in self.white_y]

    @cached_property
    def white_rms(self) -> Array:
        """Torque RMS (n,) of each axis in units of its noise's innovations."""
        return np.asarray(self.torque_rms / self.model.noise.scale)

    @cached_property
    def angles(self) -> Array:
        """Smoothed angles (R, n)."""
        return self.raw([b.angles for b in self.model.blocks])

    @cached_property
    def rates(self) -> Array:
        """Smoothed rates (R, n)."""
        return self.raw([b.smooth(b.run.motion.thetad) for b in self.model.blocks])

    @cached_property
    def runs(self) -> list[slice]:
        """Rows of each run."""
        edges = np.cumsum([0, *(int(good.sum()) for good in self.model.kept)])
        return [slice(int(a), int(b)) for a, b in pairwise(edges)]

    def level(self, axis: int, values: Array) -> Array:
        """Values (R,) of an axis without a straight line through each run, as offsets wander from
        run to run, where it moves; zero elsewhere."""
        levelled = values * self.moving[axis]
        for run in self.runs:
            base = line(self.moving[axis][run])
            levelled[run] -= base @ (base.T @ values[run])
        return levelled

    def raw(self, values: Sequence[Array]) -> Array:
        """Rows (R, ...) of values (m, ...) in each block."""
        return kept(self.model, values)

    def white(self, axis: int, values: Sequence[Array]) -> Array:
        """Whitened rows (R, k) of values (m[, k]) of an axis in each block."""
        return self.model.white(axis, values)


def kept(model: Calibrated, values: Sequence[Array]) -> Array:
    """Rows that count (R, ...) of values (m, ...) in each block."""
    return np.concatenate([v[good] for v, good in zip(values, model.kept, strict=True)])

"""Rows of all runs, axis by axis: whitened ones for the fit, ones in N m for the score."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.calibrate import Calibrated

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True)
class Rows:
    """y[i] (R,) = B[i] (R, nb) q on each axis i [N m]; white_y, white_B: the same whitened.

    fold (R,): trajectory, or stretch of an only one; partner (R,): the same instant of another
    pass, or the row itself. prior (nb,): inverse variance of q; torque_rms (n,) [N m].
    """

    made: Calibrated
    y: tuple[Array, ...]
    B: tuple[Array, ...]
    white_y: tuple[Array, ...]
    white_B: tuple[Array, ...]
    fold: Index
    partner: Index
    mutual: bool
    prior: Array
    torque_rms: Array

    @staticmethod
    def of(made: Calibrated) -> Rows:
        """Rows of a calibrated base model."""
        layout, n = made.layout, made.base.n
        count = len(layout.axis) // n
        prior = np.array([1.0 if np.isfinite(k.tolerance) else 0.0 for k in made.known])
        y, B = ([[v[:, i] for v in listed] for i in range(n)] for listed in (made.y, made.B))
        return Rows(
            made,
            tuple(kept(made, v) for v in y),
            tuple(kept(made, v) for v in B),
            tuple(made.white(i, v)[:, 0] for i, v in enumerate(y)),
            tuple(made.white(i, v) for i, v in enumerate(B)),
            layout.fold[:count],
            layout.partner[:count],
            bool(layout.mutual),
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

    @cached_property
    def folds(self) -> list[int]:
        """Numbers of the folds."""
        return [int(f) for f in np.unique(self.fold)]

    @cached_property
    def repeats(self) -> bool:
        """Whether any trajectory was run twice."""
        return bool((self.partner != np.arange(len(self.partner))).any())

    def between(self, left: Array, right: Array, where: NDArray[np.bool_]) -> Array:
        """Products (k, ...) between passes of columns on the rows `where`: noise drops out."""
        product = left[where].T @ right[self.partner][where]
        if not self.mutual:
            product = (product + left[self.partner][where].T @ right[where]) / 2
        return np.asarray(product)

    @property
    def count(self) -> int:
        """Rows of an axis."""
        return len(self.fold)

    @cached_property
    def white_rms(self) -> Array:
        """Torque RMS (n,) of each axis in units of its noise's innovations."""
        return np.asarray(self.torque_rms / self.made.noise.scale)


def kept(made: Calibrated, values: Sequence[Array]) -> Array:
    """Rows that count (R, ...) of values (m, ...) in each block."""
    return np.concatenate([v[good] for v, good in zip(values, made.kept, strict=True)])

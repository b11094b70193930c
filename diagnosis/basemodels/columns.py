"""A base model that is given by its columns alone; all else of `Base` has a default here.

tau = B(theta, thetad, thetadd) p,  B (samples, n, n_p) of each sample by itself
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from flexhex.diagnosis.basemodels.base import LATE, Geometry, Known, Motion, Stated
from flexhex.diagnosis.kinds import Kinds
from flexhex.fmus.common.machine.effect_use import EffectUse

Array = NDArray[np.float64]
CHUNK = 4000
"""Samples whose columns are held at a time."""
WINDOW, SPACING = 0.0105, 0.005
"""Smoothing window and time between two rows [s], where the log is fast enough."""


class ColumnBase:
    """Axes of these kinds with parameters `linear`, sampled every ts [s]; see
    `flexhex.diagnosis.basemodels.base.Base`. A class below says what `columns` are."""

    settle = 0.0
    late = LATE
    holds: frozenset[str] = frozenset()
    given: tuple[EffectUse, ...] = ()
    stated = Stated()
    payload: tuple[int, ...] = ()
    rotors: tuple[int, ...] = ()
    reach = np.inf
    complete = False
    curved: tuple[Known, ...] = ()
    widths: tuple[Known, ...] = ()
    geometry: Geometry | None = None

    def __init__(self, kinds: Kinds, linear: Sequence[Known], ts: float) -> None:
        self.n, self.kinds, self.linear = len(kinds), kinds, tuple(linear)
        self.window = max(WINDOW, 16 * ts)
        self.spacing = max(SPACING, 2 * ts)

    def columns(self, theta: Array, thetad: Array, thetadd: Array) -> Array:
        """Columns (samples, n, len(linear)) of a motion, each argument (samples, n)."""
        raise NotImplementedError

    def loaded(self, p: Array, payload: float) -> Array:
        """A payload may be anywhere."""
        return p

    def rows(self, motion: Motion, weights: csr_array) -> Array:
        """Smoothed columns (rows, n, len(linear)), in chunks of the samples that count."""
        flat = np.zeros((weights.shape[0], self.n * len(self.linear)))
        places = np.unique(weights.indices[weights.data > 0])
        moved = [v[places] for v in (motion.theta, motion.thetad, motion.thetadd)]
        seen = weights[:, places]
        for part, columns in self._parts(*moved):
            flat += seen[:, part] @ columns.reshape(len(columns), -1)
        return flat.reshape(-1, self.n, len(self.linear))

    def bend(self, motion: Motion, widths: Array) -> tuple[Array, Array]:
        """No curved terms."""
        empty = np.zeros((len(motion.theta), 0))
        return empty, empty

    def torque(self, motion: Motion, p: Array) -> Array:
        """B p (samples, n) [N m, N]."""
        moved = motion.theta, motion.thetad, motion.thetadd
        return np.concatenate([columns @ p for _, columns in self._parts(*moved)])

    def whole(self, motion: Motion, p: Array) -> Mapping[str, Array]:
        """Nothing is known of the mechanism as a whole."""
        return {}

    def _parts(self, *moved: Array) -> Iterator[tuple[slice, Array]]:
        for at in range(0, len(moved[0]), CHUNK):
            part = slice(at, at + CHUNK)
            yield part, self.columns(*(v[part] for v in moved))

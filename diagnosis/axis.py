"""Axes of which nothing is known: each by itself an inertia with gravity, spring and damping.

    tau = o + J thetadd + d thetad + k theta + g_s sin(theta) + g_c cos(theta)

of an axis that turns; along a line gravity is the same everywhere, so an axis that slides has

    f = o + m xdd + d xd + k x

Dry friction is left out on purpose: it is for the library to find.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from flexhex.diagnosis.base import LATE, Geometry, Known, Motion
from flexhex.diagnosis.kinds import ROTARY, Kind, Kinds
from flexhex.fmus.common.machine.effect_use import EffectUse

Array = NDArray[np.float64]
SHARED = (("d", "N m s/rad"), ("k", "N m/rad"))
TURNING = (("g_s", "N m"), ("g_c", "N m"))
"""Terms, after offset and inertia, of all axes, and more of those that turn."""
CARRIED = {True: ("J", "g_s", "g_c"), False: ("m", "o")}
"""Terms that a payload changes, of an axis that turns and of one that slides."""
WINDOW = 0.025
"""Smoothing window [s]: the noise of an encoder of a few urad, differentiated twice, must not look
like a part of the inertia that lags behind; modes up to some 40 Hz stay visible."""


def terms(kind: Kind) -> tuple[tuple[str, str], ...]:
    """Parameters of an axis: names, and units that they have where it turns."""
    own = (("o", "N m"), (kind.inertia, "kg m2"), *SHARED)
    return (*own, *TURNING) if kind.turns else own


class AxisBase:
    """n axes of unknown mass, sampled every ts [s], that turn unless `kinds` says otherwise; see
    `flexhex.diagnosis.base.Base`."""

    settle = 0.2
    late = LATE
    holds = frozenset({"viscous_friction", "drive_gain"})
    given: tuple[EffectUse, ...] = ()
    reach = np.inf
    complete = False
    curved: tuple[Known, ...] = ()
    widths: tuple[Known, ...] = ()
    geometry: Geometry | None = None

    def __init__(self, n: int, ts: float, kinds: Kinds = ()) -> None:
        self.n, self.kinds = n, kinds or (ROTARY,) * n
        self.window = max(WINDOW, 8 * ts)
        self.spacing = max(WINDOW / 4, 2 * ts)
        self.linear = tuple(
            Known(f"{name}[{i + 1}]", kind.unit(unit), 0.0, np.inf, name, i)
            for i, kind in enumerate(self.kinds)
            for name, unit in terms(kind)
        )
        edges = np.cumsum([0, *(len(terms(kind)) for kind in self.kinds)])
        self._parts = [slice(int(a), int(b)) for a, b in pairwise(edges)]
        self.payload = tuple(
            place
            for place, known in enumerate(self.linear)
            if known.group in CARRIED[self.kinds[known.axis or 0].turns]
        )

    def loaded(self, p: Array, payload: float) -> Array:
        """A payload may be anywhere."""
        return p

    def directions(self) -> Mapping[str, Array]:
        """Nothing has a nominal value."""
        return {}

    def _terms(self, motion: Motion, axis: int) -> Array:
        """Columns (samples, k) of an axis, as `terms` lists them."""
        x, xd, xdd = (v[:, axis] for v in (motion.theta, motion.thetad, motion.thetadd))
        more = (np.sin(x), np.cos(x)) if self.kinds[axis].turns else ()
        return np.stack([np.ones_like(x), xdd, xd, x, *more], axis=1)

    def rows(self, motion: Motion, weights: csr_array) -> Array:
        """Smoothed columns (rows, n, len(linear))."""
        dense = np.zeros((weights.shape[0], self.n, len(self.linear)))
        for i, part in enumerate(self._parts):
            dense[:, i, part] = weights @ self._terms(motion, i)
        return dense

    def bend(self, motion: Motion, widths: Array) -> tuple[Array, Array]:
        """No curved terms."""
        empty = np.zeros((len(motion.theta), 0))
        return empty, empty

    def torque(self, motion: Motion, p: Array) -> Array:
        """B p (samples, n) [N m, N]."""
        parts = enumerate(self._parts)
        return np.stack([self._terms(motion, i) @ p[part] for i, part in parts], axis=1)

    def whole(self, motion: Motion, p: Array) -> Mapping[str, Array]:
        """A tilted base cannot be told from the gravity terms."""
        return {}

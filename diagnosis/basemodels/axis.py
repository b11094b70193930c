"""Axes of which nothing is known: each by itself an inertia with gravity, spring and damping.

    tau = o + J thetadd + d thetad + k theta + g_s sin(theta) + g_c cos(theta)

of an axis that turns; along a line gravity is the same everywhere, so an axis that slides has

    f = o + m xdd + d xd + k x

Dry friction is left out on purpose: it is for the library to find.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Known
from flexhex.diagnosis.basemodels.columns import ColumnBase
from flexhex.diagnosis.kinds import ROTARY, Kind, Kinds, absolute

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


class AxisBase(ColumnBase):
    """n axes of unknown mass, sampled every ts [s], that turn unless `kinds` says otherwise; see
    `flexhex.diagnosis.basemodels.base.Base`."""

    settle = 0.2
    holds = frozenset({"viscous_friction", "torque_offset", "linear_stiffness", "drive_gain"})

    def __init__(self, n: int, ts: float, kinds: Kinds = ()) -> None:
        kinds = kinds or (ROTARY,) * n
        linear = tuple(
            Known(
                f"{name}[{i + 1}]",
                absolute(kind).unit(unit),
                0.0,
                np.inf,
                name,
                i,
                shown=kind.unit(unit),
            )
            for i, kind in enumerate(kinds)
            for name, unit in terms(kind)
        )
        super().__init__(kinds, linear, ts)
        self.window = max(WINDOW, 8 * ts)
        self.spacing = max(WINDOW / 4, 2 * ts)
        edges = np.cumsum([0, *(len(terms(kind)) for kind in kinds)])
        self._own = [slice(int(a), int(b)) for a, b in pairwise(edges)]
        self.payload = tuple(
            place
            for place, known in enumerate(linear)
            if known.group in CARRIED[kinds[known.axis or 0].turns]
        )

    @property
    def traceable(self) -> Callable[[Array, Array, Array], Array]:
        """Columns that take symbols, too."""
        return self.columns

    def columns(self, theta: Array, thetad: Array, thetadd: Array) -> Array:
        """Columns (samples, n, len(linear)), of each axis as `terms` lists them."""
        columns = np.zeros((len(theta), self.n, len(self.linear)), dtype=theta.dtype)
        for i, (kind, own) in enumerate(zip(self.kinds, self._own, strict=True)):
            x, xd, xdd = theta[:, i], thetad[:, i], thetadd[:, i]
            more = (np.sin(x), np.cos(x)) if kind.turns else ()
            columns[:, i, own] = np.stack([np.ones_like(x), xdd, xd, x, *more], axis=1)
        return columns

"""Axes of which nothing is known: each by itself an inertia with gravity, spring and damping.

    tau = o + J thetadd + d thetad + k theta + g_s sin(theta) + g_c cos(theta)

Dry friction is left out on purpose: it is for the library to find.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from flexhex.diagnosis.base import LATE, Known, Motion
from flexhex.fmus.common.machine.effect_use import EffectUse

Array = NDArray[np.float64]
TERMS = (
    ("o", "N m"),
    ("J", "kg m2"),
    ("d", "N m s/rad"),
    ("k", "N m/rad"),
    ("g_s", "N m"),
    ("g_c", "N m"),
)
CARRIED = frozenset({"J", "g_s", "g_c"})
"""Terms that a payload changes."""
WINDOW = 0.025
"""Smoothing window [s]: the noise of an encoder of a few urad, differentiated twice, must not look
like a part of the inertia that lags behind; modes up to some 40 Hz stay visible."""


class AxisBase:
    """n axes of unknown mass, sampled every ts [s]; see `flexhex.diagnosis.base.Base`."""

    settle = 0.2
    late = LATE
    holds = frozenset({"viscous_friction"})
    given: tuple[EffectUse, ...] = ()
    reach = np.inf
    complete = False
    curved: tuple[Known, ...] = ()
    widths: tuple[Known, ...] = ()

    def __init__(self, n: int, ts: float) -> None:
        self.n = n
        self.window = max(WINDOW, 8 * ts)
        self.spacing = max(WINDOW / 4, 2 * ts)
        self.linear = tuple(
            Known(f"{name}[{i + 1}]", unit, 0.0, np.inf, name, i)
            for i in range(n)
            for name, unit in TERMS
        )
        changed = [k for k, known in enumerate(self.linear) if known.group in CARRIED]
        self.payload = tuple(changed)

    def loaded(self, p: Array, payload: float) -> Array:
        """A payload may be anywhere."""
        return p

    def directions(self) -> Mapping[str, Array]:
        """Nothing has a nominal value."""
        return {}

    def _terms(self, motion: Motion) -> Array:
        """Terms of every axis (samples, n, 6)."""
        angle = motion.theta
        listed = (
            np.ones_like(angle),
            motion.thetadd,
            motion.thetad,
            angle,
            np.sin(angle),
            np.cos(angle),
        )
        return np.stack(listed, axis=2)

    def rows(self, motion: Motion, weights: csr_array) -> Array:
        """Smoothed columns (rows, n, 6 n)."""
        terms = self._terms(motion)
        size = len(TERMS)
        dense = np.zeros((weights.shape[0], self.n, size * self.n))
        for i in range(self.n):
            dense[:, i, size * i : size * (i + 1)] = weights @ terms[:, i]
        return dense

    def bend(self, motion: Motion, widths: Array) -> tuple[Array, Array]:
        """No curved terms."""
        empty = np.zeros((len(motion.theta), 0))
        return empty, empty

    def torque(self, motion: Motion, p: Array) -> Array:
        """B p (samples, n) [N m]."""
        return np.asarray(np.einsum("sik,ik->si", self._terms(motion), p.reshape(self.n, -1)))

    def whole(self, motion: Motion, p: Array) -> Mapping[str, Array]:
        """A tilted base cannot be told from the gravity terms."""
        return {}

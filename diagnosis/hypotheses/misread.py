"""What errors of an angle do to all torques that a base model says."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from flexhex.diagnosis.basemodels.base import Motion
from flexhex.diagnosis.hypotheses.signals import slow_motions
from flexhex.diagnosis.regression.calibrate import Calibrated

Array = NDArray[np.float64]
STEP = 1e-5
"""Part of its largest value by which a signal of an axis is moved to see what it does."""
SIGNALS = ("theta", "thetad", "thetadd")


class Misread:
    """The base model at angles that differ from those that the encoders read."""

    def __init__(self, model: Calibrated) -> None:
        self.model = model
        self._slopes: tuple[int, list[list[Array]]] = (-1, [])

    @cached_property
    def slow(self) -> list[tuple[Motion, csr_array]]:
        """See `slow_motions`."""
        return slow_motions(self.model)

    def turned(self, k: int, axis: int, error: Array) -> Array:
        """Torques (m, n, k) of block k for errors (samples, k) of an axis, which it reads more than
        it has turned."""
        return self._felt(k, axis, error, 0.0)

    def geared(self, k: int, axis: int, error: Array) -> Array:
        """The same of what a gear gives way: the axis' rotor moves as its encoder reads."""
        base, run = self.model.base, self.model.blocks[k].run
        return self._felt(k, axis, error, float(self.model.linear(run)[base.rotors[axis]]))

    def _felt(self, k: int, axis: int, error: Array, rotor: float) -> Array:
        """`-(d tau / d theta e + d tau / d theta' e' + (d tau / d theta'' - rotor) e'')`."""
        motion, weights = self.slow[k]
        step = round(motion.ts / self.model.blocks[k].run.motion.ts)
        by_angle, by_rate, by_acceleration = self._slopes_of(axis)[k]
        behind = by_acceleration.copy()
        behind[:, axis] -= rotor
        columns = []
        for angle in error[::step].T:
            rate = np.gradient(angle, motion.ts)
            acceleration = np.gradient(rate, motion.ts)
            pairs = (by_angle, angle), (by_rate, rate), (behind, acceleration)
            columns.append(-(weights @ sum(slope * own[:, None] for slope, own in pairs)))
        return np.stack(columns, axis=2)

    def _slopes_of(self, axis: int) -> list[list[Array]]:
        """Torques (samples, n) of each block per angle, rate and acceleration of an axis; those of
        the last axis are kept."""
        if self._slopes[0] != axis:
            self._slopes = axis, [self._slope(k, axis) for k in range(len(self.slow))]
        return self._slopes[1]

    def _slope(self, k: int, axis: int) -> list[Array]:
        motion, slopes = self.slow[k][0], list[Array]()
        for name in SIGNALS:
            moved = getattr(motion, name).copy()
            step = STEP * float(np.abs(moved[:, axis]).max()) or STEP
            moved[:, axis] += step
            torque = self._torque(k, replace(motion, **{name: moved}))
            slopes.append((torque - self._level[k]) / step)
        return slopes

    @cached_property
    def _level(self) -> list[Array]:
        return [self._torque(k, motion) for k, (motion, _) in enumerate(self.slow)]

    def _torque(self, k: int, motion: Motion) -> Array:
        fitted, base = self.model.fitted, self.model.base
        tau = base.torque(motion, self.model.linear(self.model.blocks[k].run))
        if len(base.curved):
            tau = tau + base.bend(motion, fitted.widths)[0] * fitted.gains
        return tau

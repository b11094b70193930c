"""What errors of an angle do to all torques that a base model says."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from flexhex.diagnosis.basemodels.base import Motion
from flexhex.diagnosis.hypotheses.signals import averaged, slow_weights
from flexhex.diagnosis.regression.calibrate import Calibrated

Array = NDArray[np.float64]
STEP = 1e-5
"""Part of its largest value by which a signal of an axis is moved to see what it does."""
SIGNALS = ("theta", "thetad", "thetadd")


class Misread:
    """The base model at angles that differ from those that the encoders read."""

    def __init__(self, model: Calibrated) -> None:
        self.model = model
        self._slopes: dict[int, list[list[Array]]] = {}

    @cached_property
    def motions(self) -> list[Motion]:
        """The mean motion of each row of each block: what a unit of an error does hardly changes
        within a window, while the error may."""
        return averaged(self.model)

    @cached_property
    def slow(self) -> list[tuple[int, csr_array]]:
        """See `slow_weights`."""
        return slow_weights(self.model)

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
        step, weights = self.slow[k]
        slopes = list(self._slopes_of(axis)[k])
        slopes[2] = slopes[2].copy()
        slopes[2][:, axis] -= rotor
        angle = error[::step]
        signals, ts = [angle], step * self.model.blocks[k].run.motion.ts
        for _ in slopes[1:]:
            signals.append(np.gradient(signals[-1], ts, axis=0))
        pairs = zip(slopes, signals, strict=True)
        felt = [slope[:, :, None] * (weights @ own)[:, None] for slope, own in pairs]
        return np.asarray(-np.sum(felt, axis=0))

    def inertia(self, axis: int) -> float:
        """The largest that an axis moves [kg m2]."""
        return max(float(slopes[2][:, axis].max()) for slopes in self._slopes_of(axis))

    def _slopes_of(self, axis: int) -> list[list[Array]]:
        """Torques (m, n) of each block per angle, rate and acceleration of an axis."""
        if axis not in self._slopes:
            self._slopes[axis] = [self._slope(k, axis) for k in range(len(self.motions))]
        return self._slopes[axis]

    def _slope(self, k: int, axis: int) -> list[Array]:
        motion, level, slopes = self.motions[k], self._level[k], list[Array]()
        for name in SIGNALS:
            moved = getattr(motion, name).copy()
            step = STEP * float(np.abs(moved[:, axis]).max()) or STEP
            moved[:, axis] += step
            # hysteresis goes by the way of an angle, which all angles moved together do not change
            other = replace(motion, **{name: moved})
            if other.theta is motion.theta:
                other.solved.update(motion.solved)
            slopes.append((self._torque(k, other) - level) / step)
        return slopes

    @cached_property
    def _level(self) -> list[Array]:
        return [self._torque(k, motion) for k, motion in enumerate(self.motions)]

    def _torque(self, k: int, motion: Motion) -> Array:
        return self.model.base.torque(motion, self.model.linear(self.model.blocks[k].run))

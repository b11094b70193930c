"""What errors of an angle do to all torques that a base model says."""

from __future__ import annotations

from collections.abc import Sequence
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
        return self._felt(k, axis, error, self._rotor(k, axis))

    def meshed(self, k: int, axis: int, bends: tuple[Array, Array, Array], halvings: int) -> Array:
        """The same of an error that goes with the angle of the motor: it and its first two
        derivatives by the angle (samples, k); halvings: of the samples of `Block.fewer`. The link
        turns a little slower or faster than the motor, and its torque is so much larger or smaller
        there."""
        block, rotor = self.model.blocks[k], self._rotor(k, axis)
        motion, few, (error, slope, bend) = block.run.motion, block.fewer(halvings), bends
        rate, pace = motion.thetad[:, axis, None], motion.thetadd[:, axis, None]
        signals = (error, slope * rate, bend * rate**2 + slope * pace)
        felt = self._pulled(k, axis, [few.smooth(few(own)) for own in signals], rotor)
        passed = self._level[k][:, axis] - rotor * self.motions[k].thetadd[:, axis]
        felt[:, axis] -= passed[:, None] * few.smooth(few(slope))
        return felt

    def _rotor(self, k: int, axis: int) -> float:
        base = self.model.base
        return float(self.model.linear(self.model.blocks[k].run)[base.rotors[axis]])

    def _felt(self, k: int, axis: int, error: Array, rotor: float) -> Array:
        """Torques (m, n, k) for errors (samples, k)."""
        step, weights = self.slow[k]
        signals, ts = [error[::step]], step * self.model.blocks[k].run.motion.ts
        for _ in SIGNALS[1:]:
            signals.append(np.gradient(signals[-1], ts, axis=0))
        return self._pulled(k, axis, [weights @ own for own in signals], rotor)

    def _pulled(self, k: int, axis: int, signals: Sequence[Array], rotor: float) -> Array:
        """`-(d tau / d theta e + d tau / d theta' e' + (d tau / d theta'' - rotor) e'')` of an
        error and its derivatives, smoothed (m, k) each."""
        slopes = [slope.copy() for slope in self._slopes_of(axis)[k]]
        slopes[2][:, axis] -= rotor
        pairs = zip(slopes, signals, strict=True)
        return np.asarray(
            -np.sum([slope[:, :, None] * own[:, None] for slope, own in pairs], axis=0)
        )

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

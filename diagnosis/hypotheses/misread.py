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
TURN = 1e-5
"""Part of an error by which an axis is turned to see what it does."""


class Misread:
    """The base model at angles that differ from those that the encoders read."""

    def __init__(self, model: Calibrated) -> None:
        self.model = model

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
        motion, weights = self.slow[k]
        step = round(motion.ts / self.model.blocks[k].run.motion.ts)
        columns = []
        for column in error[::step].T:
            angle, rate, acceleration = (np.zeros_like(motion.theta) for _ in range(3))
            angle[:, axis] = TURN * column
            rate[:, axis] = np.gradient(angle[:, axis], motion.ts)
            acceleration[:, axis] = np.gradient(rate[:, axis], motion.ts)
            moved = replace(
                motion,
                theta=motion.theta + angle,
                thetad=motion.thetad + rate,
                thetadd=motion.thetadd + acceleration,
            )
            more = self._torque(k, moved) - self._level[k] - rotor * acceleration
            columns.append(-(weights @ more) / TURN)
        return np.stack(columns, axis=2)

    @cached_property
    def _level(self) -> list[Array]:
        return [self._torque(k, motion) for k, (motion, _) in enumerate(self.slow)]

    def _torque(self, k: int, motion: Motion) -> Array:
        fitted, base = self.model.fitted, self.model.base
        tau = base.torque(motion, self.model.linear(self.model.blocks[k].run))
        if len(base.curved):
            tau = tau + base.bend(motion, fitted.widths)[0] * fitted.gains
        return tau

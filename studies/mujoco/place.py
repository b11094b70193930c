"""Where an effect is to be, and what moves there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from studies.mujoco.effect import Motion
from studies.mujoco.machine import Array, Machine

Axes = tuple[int, ...]


@dataclass(frozen=True)
class Place:
    """Where an effect is to be: machine, axes from 0, a run without it, rate [Hz] of logs."""

    machine: Machine
    axes: Axes
    motion: Motion
    rate: float

    @property
    def half(self) -> Array:
        """Half of the stroke (axes,)."""
        return np.asarray(np.ptp(self.motion.q, axis=0)[list(self.axes)] / 2)

    @property
    def middle(self) -> Array:
        """Middle of the stroke (axes,)."""
        q = self.motion.q[:, list(self.axes)]
        return np.asarray((q.max(axis=0) + q.min(axis=0)) / 2)

    def rms(self, name: str) -> Array:
        """RMS (axes,) of q, v, a or tau."""
        values = getattr(self.motion, name)[:, list(self.axes)]
        return np.asarray(np.sqrt(np.mean(values**2, axis=0)))

    @property
    def unit(self) -> str:
        """Of torque."""
        return self.machine.units[1]

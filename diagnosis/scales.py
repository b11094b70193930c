"""Sizes of the library's shapes and gains for the torque and the motion of an axis."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from flexhex.diagnosis.calibrate import Calibrated
from flexhex.diagnosis.kinds import Kinds, kinds_of, powers
from flexhex.fmus.common.effects import Effect, Shape

USUAL_TORQUE, USUAL_MOTION = 0.8, 0.1
"""RMS [N m] and [rad], about the mean, of an axis that the library's sizes in N m and rad are for.
Others have them in proportion: torques and forces by powers of two, lengths exactly. Angles have
the library's: a turn is a turn on every machine."""


@dataclass(frozen=True)
class Scales:
    """kinds: what each axis moves along; sizes: torque and motion of each axis, relative to what
    the library's sizes are for; effects: by id."""

    kinds: Kinds
    sizes: tuple[tuple[float, float], ...]
    effects: Mapping[str, Effect]

    @staticmethod
    def of(made: Calibrated, effects: Sequence[Effect]) -> Scales:
        """Of runs and their base model."""
        kinds, tiny = kinds_of(made.base, made.base.n), np.finfo(float).tiny
        moved = np.concatenate([b.run.motion.theta[b.run.valid] for b in made.blocks])
        found = []
        for kind, torque, motion in zip(kinds, made.torque_rms, moved.std(axis=0), strict=True):
            times = 2.0 ** round(np.log2(max(float(torque), tiny) / USUAL_TORQUE))
            fixed = kind.turns or not motion > 0
            found.append((times, 1.0 if fixed else float(motion) / USUAL_MOTION))
        return Scales(kinds, tuple(found), {effect.id: effect for effect in effects})

    def scale(self, unit: str, axis: int) -> float:
        """How much larger what the library says in a unit is on an axis."""
        (torque, motion), (a, b) = self.sizes[axis], powers(unit)
        return float(torque**a * motion**b)

    def sized(self, name: str, axis: int, shape: Mapping[str, float]) -> dict[str, float]:
        """A shape of the library for an axis."""
        units = {s.name: s.unit for s in self.effects[name].shapes}
        return {n: v * self.scale(units[n], axis) for n, v in shape.items()}

    def ranges(self, name: str, axis: int) -> dict[str, Shape]:
        """Shapes of an effect with bounds and grid for an axis."""
        found = {}
        for s in self.effects[name].shapes:
            times = self.scale(s.unit, axis)
            low, high, start = (times * value for value in (s.low, s.high, s.start))
            grid = tuple(times * value for value in s.grid)
            found[s.name] = replace(s, low=low, high=high, start=start, grid=grid)
        return found

    def bounds(self, name: str, axis: int) -> list[tuple[float, float]]:
        """Least and largest gains of an effect on an axis."""
        pairs = [(gain, self.scale(gain.unit, axis)) for gain in self.effects[name].gains]
        return [(times * gain.low, times * gain.high) for gain, times in pairs]

"""Sizes of the library's shapes and gains for the torque and the motion of an axis."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from flexhex.diagnosis.kinds import Kinds, kinds_of, powers
from flexhex.diagnosis.regression.calibrate import Calibrated
from flexhex.fmus.common.effects import Effect, Shape

USUAL_TORQUE, USUAL_MOTION, USUAL_RATE = 0.8, 0.1, 0.35
"""RMS [N m], [rad] and [rad/s], the first two about the mean, of an axis that the library's sizes
in these units are for. Others have them in proportion: torques, angles and rates by powers of two,
lengths and speeds along a line exactly. Orders of an angle are the library's: a turn is a turn on
every machine."""
USUAL_TIME = 200.0
"""Time [s] that the library's long time constants are around, from a tenth to ten times of it: of
a shorter one all is over soon, a longer one is a straight line."""
TURNS, RATE, HERTZ = "1/rad", "rad/s", "Hz"
FASTEST = 2.0
"""Periods within the smoothing window of the fastest mode that can be told: there its Hann weights
have their first zero. Of a faster one they leave no resonance, and all that answers linearly to
the acceleration looks alike. Over the studies kept: with half as many a right mode is lost, with
twice as many nothing changes; a wrong name had 12."""
PERIODS = 1.0
"""Least periods of a wave over the stroke: of a part of one an axis sees a spring. With 1.5
a ripple of 1.03 periods was not found."""


@dataclass(frozen=True)
class Scales:
    """kinds: what each axis moves along; sizes: torque, motion and rate of each axis, relative to
    what the library's sizes are for; places: mean angle of each axis; slowest: order of a wave that
    has `PERIODS` over its stroke; peaks: its largest torque;
    usual: the larger of its RMS about the mean and its median magnitude [N m]; time: that the runs
    tell, relative to the library's; fastest: frequency of a mode [Hz]; effects: by id."""

    kinds: Kinds
    sizes: tuple[tuple[float, float, float], ...]
    places: tuple[float, ...]
    slowest: tuple[float, ...]
    peaks: tuple[float, ...]
    usual: tuple[float, ...]
    time: float
    fastest: float
    effects: Mapping[str, Effect]

    @staticmethod
    def of(model: Calibrated, effects: Sequence[Effect], across: bool = False) -> Scales:
        """Of runs and their base model; across: time goes on from run to run."""
        kinds, tiny = kinds_of(model.base, model.base.n), np.finfo(float).tiny
        theta = np.concatenate([b.run.motion.theta[b.run.valid] for b in model.blocks])
        places, angles = tuple(theta.mean(axis=0).tolist()), theta.std(axis=0)
        stroke = np.maximum(np.ptp(theta, axis=0), 2 * np.pi * tiny)
        slowest = tuple((2 * np.pi * PERIODS / stroke).tolist())
        rates = np.concatenate([b.run.motion.thetad[b.run.valid] for b in model.blocks])
        speeds = np.sqrt((rates**2).mean(axis=0))
        ranges = []
        for kind, torque, angle, speed in zip(kinds, model.torque_rms, angles, speeds, strict=True):
            times = _power_of_two(max(float(torque), tiny) / USUAL_TORQUE)
            moved = [float(angle) / USUAL_MOTION, float(speed) / USUAL_RATE]
            own = [_power_of_two(v) if kind.turns and v > 0 else v or 1.0 for v in moved]
            ranges.append((times, own[0], own[1]))
        taus = np.abs(np.concatenate([b.run.tau.values[b.run.tau.valid] for b in model.blocks]))
        peaks = tuple(np.maximum(taus.max(axis=0), tiny).tolist())
        usual = tuple(np.maximum(model.torque_rms, np.median(taus, axis=0)).tolist())
        ends = [
            b.run.motion.time[-1] - b.run.motion.t0 + across * b.run.start for b in model.blocks
        ]
        time = _power_of_two(max(float(max(ends)), tiny) / USUAL_TIME)
        known = {effect.id: effect for effect in effects}
        fastest = FASTEST / model.base.window
        return Scales(kinds, tuple(ranges), places, slowest, peaks, usual, time, fastest, known)

    def scale(self, unit: str, axis: int) -> float:
        """How much larger what the library says in a unit is on an axis."""
        (torque, motion, rate), (a, b) = self.sizes[axis], powers(unit)
        if unit == RATE:
            return rate
        if unit == TURNS and self.kinds[axis].turns:
            return 1.0
        return float(torque**a * motion**b)

    def _times(self, shape: Shape, axis: int) -> float:
        """How much larger a shape of the library is on an axis."""
        if shape.as_is:
            return 1.0
        if shape.of_time:
            return self.time
        return self.peaks[axis] if shape.of_peak else self.scale(shape.unit, axis)

    def _sized(self, shape: Shape, axis: int, *values: float) -> tuple[float, ...]:
        """Values of the library's for a shape, on an axis."""
        times, place = self._times(shape, axis), self.places[axis] if shape.of_place else 0.0
        return tuple(place + times * value for value in values)

    def sized(self, name: str, axis: int, shape: Mapping[str, float]) -> dict[str, float]:
        """A shape of the library for an axis."""
        known = {s.name: s for s in self.effects[name].shapes}
        return {n: self._sized(known[n], axis, v)[0] for n, v in shape.items()}

    def possible(self, name: str, axis: int, shape: Mapping[str, float]) -> bool:
        """Whether an axis may have such a shape."""
        ranges = self.ranges(name, axis)
        return all(ranges[n].low <= v <= ranges[n].high for n, v in shape.items())

    def ranges(self, name: str, axis: int) -> Mapping[str, Shape]:
        """Shapes of an effect with bounds and grid for an axis."""
        if (name, axis) not in self._ranges:
            self._ranges[name, axis] = self._ranged(name, axis)
        return self._ranges[name, axis]

    @cached_property
    def _ranges(self) -> dict[tuple[str, int], Mapping[str, Shape]]:
        """Those that were asked for: a search asks for every shape."""
        return {}

    def _ranged(self, name: str, axis: int) -> Mapping[str, Shape]:
        shapes = {}
        for s in self.effects[name].shapes:
            low, high, start, *grid = self._sized(s, axis, s.low, s.high, s.start, *s.grid)
            # an axis that passes such a share most of the time would not move as it does
            low = max(low, self.usual[axis]) if s.of_peak else low
            # of a wave of which an axis sees a part it sees a spring
            low = max(low, self.slowest[axis]) if s.unit == TURNS and not s.as_is else low
            # what is over soon is no drift
            low = max(low, grid[0]) if s.of_time else low
            open_ = s.unit == HERTZ and not s.as_is and high > self.fastest
            high = self.fastest if open_ else high
            within = tuple(value for value in grid if low <= value <= high)
            shapes[s.name] = replace(s, low=low, high=high, start=start, grid=within, open=open_)
        return shapes

    def bounds(self, name: str, axis: int) -> list[tuple[float, float]]:
        """Least and largest gains of an effect on an axis."""
        pairs = [(gain, self.scale(gain.unit, axis)) for gain in self.effects[name].fitted]
        return [(times * gain.low, times * gain.high) for gain, times in pairs]


def _power_of_two(value: float) -> float:
    """The nearest one."""
    return float(2.0 ** round(np.log2(value)))

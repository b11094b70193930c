"""Lag or delay of a drive: to first order the same, told apart by how much a drive gives away.

A lag T loses amplitude, ln 1/(1 + s T) = -s T + (s T)^2/2 - ..., and a delay does not:
ln exp(-s T) = -s T. So with

    tau_meas(t) = g (u(t - T) + k2 u''(t - T)) + o

k2 is T^2/2 more than that of drives which are not late for a lag, and no more for a delay. Two
lags of half the time, or a delay and a lag, lie between: then nothing is said.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.signal import lfilter

from diagnosis.blocks import Block, Run, blocks
from diagnosis.calibrate import Calibrated
from diagnosis.candidates import Bench
from diagnosis.compiled import Compiled
from diagnosis.path import Driven, PathBase, driven

Array = NDArray[np.float64]
LAG, DELAY = "drive_lag", "time_delay"
SECOND = 1.0
"""Length [s] of a stretch in which errors go together."""
INEXACT = 0.15
"""One standard deviation by which k2 of a real lag or delay may differ from that of an ideal one,
relative to T^2/2."""
FITS, APART = 9.0, 16.0
"""Largest mean square deviation of the answer, and by how much more its rival deviates in all."""


@dataclass(frozen=True)
class Bend:
    """What a drive makes of its command: late [s], the first order, and k2 [s2], the second one
    beyond a delay's, with their standard deviations."""

    late: float
    late_deviation: float
    k2: float
    deviation: float


@dataclass(frozen=True)
class Late:
    """A late drive: id (`drive_lag` or `time_delay`), time [s]; text: what that rests on."""

    id: str
    time: float
    text: str

    def of(self, command: Array, ts: float) -> Array:
        """A command (samples,) every ts [s] as the drive follows it, exact for straight lines."""
        if self.id == DELAY:
            clock = ts * np.arange(len(command))
            return np.asarray(CubicSpline(clock, command)(np.maximum(clock - self.time, 0.0)))
        left = np.exp(-ts / self.time)
        gone = (1.0 - left) * self.time / ts
        start = [gone * command[0]]
        return np.asarray(lfilter([1.0 - gone, gone - left], [1.0, -left], command, zi=start)[0])


class LateBench(Bench):
    """Candidates beside drives that are known to be late: they have the exact columns of that,
    (u - what the drive makes of u) / time, instead of u'."""

    def __init__(
        self, made: Calibrated, effects: Sequence[Compiled], late: Mapping[int, Late]
    ) -> None:
        """late: by axis from 0."""
        super().__init__(made, effects)
        self.late = late

    def beside(self, made: Calibrated) -> Bench:
        """The same candidates along other runs."""
        return LateBench(made, list(self.effects.values()), self.late)

    def names(self, axis: int | None) -> list[str]:
        """Without the one of lag and delay that a late drive has not."""
        found = super().names(axis)
        if axis is None or axis not in self.late:
            return found
        return [name for name in found if name == self.late[axis].id or name not in (LAG, DELAY)]

    def thin(self, name: str, axis: int, shape: Mapping[str, float]) -> list[Array]:
        """See `Bench.thin`."""
        if name not in (LAG, DELAY) or axis not in self.late:
            return super().thin(name, axis, shape)
        late, found = self.late[axis], []
        for block in self.made.blocks:
            motion = block.run.motion
            assert isinstance(motion, Driven)
            u = motion.command[:, axis]
            found.append(block.smooth((u - late.of(u, motion.ts)) / late.time)[:, None])
        return found


def lag_or_delay(
    path: PathBase,
    runs: Sequence[Run],
    common: float,
    late: Mapping[int, float],
    axes: Sequence[int],
) -> dict[int, Late]:
    """What drives are that come later than others, by axis from 0; {} where runs cannot tell.

    runs: with their commands; common: lag [s] of the drives that are not late; late: how much
    later [s] each late axis is, about; axes: those of them that are asked for together.
    """
    others = [i for i in range(path.n) if i not in late]
    if not others:
        return {}
    usual = _mean(bends(path, driven(runs, common), others))
    found = [bends(path, driven(runs, common + late[i]), [i])[0] for i in axes]
    times = np.array([late[i] + b.late - usual.late for i, b in zip(axes, found, strict=True)])
    share = np.array([bend.k2 - usual.k2 for bend in found]) / (times**2 / 2)
    chance = np.array([np.hypot(bend.deviation, usual.deviation) for bend in found])
    spread = np.hypot(chance / (times**2 / 2), INEXACT)
    lag, delay = float((((share - 1) / spread) ** 2).sum()), float(((share / spread) ** 2).sum())
    best, other, name = (lag, delay, LAG) if lag < delay else (delay, lag, DELAY)
    if best > FITS * len(axes) or other - best < APART or (times <= 0.0).any():
        return {}
    weight = spread**-2.0
    mean, reach = weight @ share / weight.sum(), 1.96 * weight.sum() ** -0.5
    text = (
        f"late drives lose {mean:.2f} +- {reach:.2f} of the amplitude that a lag loses, where a"
        " delay loses none"
    )
    return {axis: Late(name, float(t), text) for axis, t in zip(axes, times, strict=True)}


def _mean(found: Sequence[Bend]) -> Bend:
    """Weighted mean of several drives, with the spread that they show."""
    k2, deviation = (np.array([getattr(b, name) for b in found]) for name in ("k2", "deviation"))
    weight = deviation**-2.0
    mean = float(weight @ k2 / weight.sum())
    apart = float(np.sqrt(((k2 - mean) ** 2).mean()))
    late = float(np.mean([b.late for b in found]))
    return Bend(late, 0.0, mean, max(float(weight.sum() ** -0.5), apart))


def bends(path: PathBase, runs: Sequence[Run], axes: Sequence[int]) -> list[Bend]:
    """Second order of each of these axes; runs: as `diagnosis.path.driven` gives them."""
    listed = blocks(path, runs, path.spacing)
    return [_bend(listed, axis) for axis in axes]


def _bend(listed: Sequence[Block], axis: int) -> Bend:
    """Least squares of the report on the command and its derivatives, errors by stretches."""
    rows, report, stretch, count = [], [], [], 0
    for block in listed:
        motion, good = block.run.motion, block.usable
        assert isinstance(motion, Driven)
        u = motion.command[:, axis]
        first = np.gradient(u, motion.ts)
        both = np.stack([u, np.ones_like(u), first, np.gradient(first, motion.ts)], axis=1)
        rows.append(block.smooth(both)[good])
        report.append(block.smooth(motion.reported[:, axis])[good])
        places = ((block.at[good] - block.at[0]) / SECOND).astype(int) + count
        count = int(places.max(initial=count)) + 1
        stretch.append(places)
    A, y, place = np.concatenate(rows), np.concatenate(report), np.concatenate(stretch)
    size = np.sqrt((A**2).mean(axis=0))
    inverse = np.linalg.pinv((A / size).T @ (A / size))
    c = inverse @ ((A / size).T @ y)
    scores = (A / size) * (y - (A / size) @ c)[:, None]
    by_stretch = np.stack([np.bincount(place, s, count) for s in scores.T], axis=1)
    covariance = inverse @ by_stretch.T @ by_stretch @ inverse
    gain, _, slope, curve = c / size
    spread = np.sqrt(np.diag(covariance)) / size / abs(gain)
    late = -slope / gain
    values = (late, spread[2], curve / gain - late**2 / 2, spread[3])
    return Bend(*(float(value) for value in values))

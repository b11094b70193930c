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

from flexhex.diagnosis.drives.path import Driven, PathBase, driven
from flexhex.diagnosis.hypotheses.candidates import Bench
from flexhex.diagnosis.hypotheses.compiled import Compiled
from flexhex.diagnosis.regression.calibrate import Calibrated
from flexhex.diagnosis.result.verdict import NORMAL
from flexhex.diagnosis.runs.blocks import Block, blocks
from flexhex.diagnosis.runs.run import Run

Array = NDArray[np.float64]
LAG, DELAY = "drive_lag", "time_delay"
SECOND = 1.0
"""Length [s] of a stretch in which errors go together."""
INEXACT = 0.15
"""One standard deviation by which k2 of a real lag or delay may differ from that of an ideal one,
relative to T^2/2."""
STEPS = 4
"""Steps in which the time of a late drive is found."""
RESTS = 1e-6
"""Range of a command that does not move, relative to its size."""
FITS, APART = 9.0, 16.0
"""Largest mean square deviation of the answer, and by how much more its rival deviates in all."""


@dataclass(frozen=True)
class Bend:
    """What a drive makes of its command: late [s], the first order, and k2 [s2], the second one
    beyond a delay's, with their standard deviations: infinite where the command rests."""

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
        """A command (samples,) every ts [s] as the drive follows it, exact for a cubic spline."""
        # they take longer to load than all else of most diagnoses
        from scipy.interpolate import CubicSpline
        from scipy.signal import lfilter

        clock = ts * np.arange(len(command))
        spline = CubicSpline(clock, command)
        if self.id == DELAY:
            return np.asarray(spline(np.maximum(clock - self.time, 0.0)))
        # y' = (u - y) / T over a step: what is left of y, and a moment for each power of u
        left, moment = np.exp(-ts / self.time), -np.expm1(-ts / self.time)
        fed = np.zeros(len(command) - 1)
        for power in range(4):
            fed += moment * ts**power * spline.c[3 - power]
            moment = 1.0 - (power + 1) * self.time / ts * moment
        return np.asarray(lfilter([1.0], [1.0, -left], np.append(command[0], fed)))


class LateBench(Bench):
    """Candidates beside drives that are known to be late: they have the exact columns of that,
    (u - what the drive makes of u) / time, instead of u'."""

    def __init__(
        self, model: Calibrated, effects: Sequence[Compiled], late: Mapping[int, Late]
    ) -> None:
        """late: by axis from 0."""
        super().__init__(model, effects)
        self.late = late

    def beside(self, model: Calibrated) -> Bench:
        """The same candidates along other runs."""
        return LateBench(model, list(self.effects.values()), self.late)

    def names(self, axis: int | None) -> list[str]:
        """Without the one of lag and delay that a late drive has not."""
        names = super().names(axis)
        if axis is None or axis not in self.late:
            return names
        return [name for name in names if name == self.late[axis].id or name not in (LAG, DELAY)]

    def thin(self, name: str, axis: int, shape: Mapping[str, float]) -> list[Array]:
        """See `Bench.thin`."""
        if name not in (LAG, DELAY) or axis not in self.late:
            return super().thin(name, axis, shape)
        late, thinned = self.late[axis], []
        for block in self.model.blocks:
            motion = block.run.motion
            assert isinstance(motion, Driven)
            u = motion.command[:, axis]
            thinned.append(block.smooth((u - late.of(u, motion.ts)) / late.time)[:, None])
        return thinned


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
    listed = blocks(path, driven(runs, common), path.spacing)
    others = [bend(listed, i) for i in range(path.n) if i not in late]
    known = [one for one in others if np.isfinite(one.deviation)]
    if not known:
        return {}
    usual = _mean(known)
    lag, delay = ([_tried(listed, i, name, late[i], usual) for i in axes] for name in (LAG, DELAY))
    wrong = {name: sum(t.off**2 for t in tried) for name, tried in ((LAG, lag), (DELAY, delay))}
    name = min(wrong, key=lambda key: wrong[key])
    best, other = wrong[name], max(wrong.values())
    tried = lag if name == LAG else delay
    if best > FITS * len(axes) or other - best < APART or any(t.time <= 0.0 for t in tried):
        return {}
    spread = np.array([t.spread for t in lag])
    share = np.array([1.0 + t.off * t.spread for t in lag])
    weight = spread**-2.0
    mean = float(weight @ share / weight.sum())
    reach = float(NORMAL * weight.sum() ** -0.5)
    text = (
        f"high-frequency attenuation is {mean:.2f} ± {reach:.2f} of that of a first-order lag (1 is"
        " a lag, 0 a pure delay)"
    )
    return {axis: Late(name, t.time, text) for axis, t in zip(axes, tried, strict=True)}


@dataclass(frozen=True)
class _Tried:
    """A drive taken for a lag or a delay of `time` [s]: what it loses more than that, relative to
    what a lag of that time loses, as a number `off` of standard deviations `spread`."""

    time: float
    off: float
    spread: float


def _tried(listed: Sequence[Block], axis: int, name: str, time: float, usual: Bend) -> _Tried:
    """Its time in a few steps, with the exact form of what it is taken for."""
    estimate = usual
    for _ in range(STEPS):
        if time <= 0.0:
            return _Tried(0.0, np.inf, 1.0)
        estimate = bend(listed, axis, Late(name, time, ""))
        time += estimate.late - usual.late
    whole = max(time, 1e-9) ** 2 / 2
    spread = float(np.hypot(np.hypot(estimate.deviation, usual.deviation) / whole, INEXACT))
    return _Tried(time, (estimate.k2 - usual.k2) / whole / spread, spread)


def _mean(listed: Sequence[Bend]) -> Bend:
    """Weighted mean of several drives, with the spread that they show."""
    k2, deviation = (np.array([getattr(b, name) for b in listed]) for name in ("k2", "deviation"))
    weight = deviation**-2.0
    mean = float(weight @ k2 / weight.sum())
    apart = float(np.sqrt(((k2 - mean) ** 2).mean()))
    late = float(np.mean([b.late for b in listed]))
    return Bend(late, 0.0, mean, max(float(weight.sum() ** -0.5), apart))


def bends(path: PathBase, runs: Sequence[Run], axes: Sequence[int]) -> list[Bend]:
    """Second order of each of these axes; runs: as `path.driven` gives them."""
    listed = blocks(path, runs, path.spacing)
    return [bend(listed, axis) for axis in axes]


def bend(listed: Sequence[Block], axis: int, late: Late | None = None) -> Bend:
    """Least squares of the report on the command and its derivatives, errors by stretches.

    late: what has been done to the command already.
    """
    rows, report, stretch, count = [], [], [], 0
    for block in listed:
        motion, good = block.run.motion, block.usable
        assert isinstance(motion, Driven)
        u = motion.command[:, axis]
        u = u if late is None else late.of(u, motion.ts)
        first = np.gradient(u, motion.ts)
        both = np.stack([u, np.ones_like(u), first, np.gradient(first, motion.ts)], axis=1)
        rows.append(block.smooth(both)[good])
        report.append(block.smooth(motion.reported[:, axis])[good])
        places = ((block.at[good] - block.at[0]) / SECOND).astype(int) + count
        count = int(places.max(initial=count)) + 1
        stretch.append(places)
    A, y, place = np.concatenate(rows), np.concatenate(report), np.concatenate(stretch)
    if not len(A) or np.ptp(A[:, 0]) <= RESTS * np.abs(A[:, 0]).max():
        return Bend(0.0, np.inf, 0.0, np.inf)
    size = np.sqrt((A**2).mean(axis=0))
    inverse = np.linalg.pinv((A / size).T @ (A / size))
    c = inverse @ ((A / size).T @ y)
    scores = (A / size) * (y - (A / size) @ c)[:, None]
    by_stretch = np.stack([np.bincount(place, s, count) for s in scores.T], axis=1)
    covariance = inverse @ by_stretch.T @ by_stretch @ inverse
    gain, _, slope, curve = c / size
    spread = np.sqrt(np.diag(covariance)) / size / abs(gain)
    time = -slope / gain
    values = (time, spread[2], curve / gain - time**2 / 2, spread[3])
    return Bend(*(float(value) for value in values))

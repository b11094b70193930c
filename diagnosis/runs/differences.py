"""Rates and accelerations of a run: central differences of its angles, or measured."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import convolve1d, uniform_filter1d

from flexhex.diagnosis import stencils
from flexhex.diagnosis.basemodels.base import Motion
from flexhex.diagnosis.logs import Channel
from flexhex.diagnosis.reversals import angle_noise
from flexhex.diagnosis.runs.run import TimeSeries
from flexhex.fmus.filter.equations import hann

Array = NDArray[np.float64]
BLENDED = 0.1
"""Window [s] below which rates are integrated accelerations, where only these are measured."""


def motion_of(
    theta: TimeSeries, rates: Channel | None = None, accelerations: Channel | None = None
) -> Motion:
    """All but two samples at either end; rates and accelerations from their own channels where
    there are any.

    Differences of fourth order: those of second order lose a thousandth of an inertia's torque at
    20 Hz, which would look like an effect.
    """
    th, ts = theta.values, theta.ts
    time = np.asarray(theta.t0 + ts * np.arange(len(th)), dtype=np.float64)
    rate = None if rates is None else _at(rates, time, ts)
    first = stencils.first(th, ts) if rate is None else rate[2:-2]
    if accelerations is not None:
        faster = _at(accelerations, time, ts)
        second = faster[2:-2]
        if rate is None:
            first = _blended(first, th, faster, ts)[2:-2]
    elif rate is not None:
        second = stencils.first(rate, ts)
    else:
        second = stencils.second(th, ts)
    start, noise = theta.t0 + 2 * ts, angle_noise(th)
    derived = rates is None and accelerations is None
    return Motion(start, ts, th[2:-2], first, second, noise=noise, derived=derived)


def _blended(rate: Array, theta: Array, acceleration: Array, ts: float) -> Array:
    """Rates (samples, n): fast changes those of the integrated acceleration, slow ones those of the
    angles, exact where both are; plain differences `rate`, two samples short at either end, where
    the window reaches beyond the run."""
    blended = np.pad(rate, ((2, 2), (0, 0)), mode="edge")
    points = 2 * round(BLENDED / ts / 2)
    if points < 4 or len(theta) < 2 * points:
        return blended
    added = np.zeros_like(acceleration)
    np.cumsum(ts * (acceleration[1:] + acceleration[:-1]) / 2, axis=0, out=added[1:])
    weights = hann(points)[1:]  # symmetric about its middle
    slow, gone = (convolve1d(v, weights, axis=0) for v in (theta, added))
    part = slice(points // 2, -points // 2)
    blended[part] = (np.gradient(slow, ts, axis=0) + added - gone)[part]
    return blended


def _at(channel: Channel, time: Array, ts: float) -> Array:
    """Values (samples, n) at these times, every ts [s]; means of those of a faster channel."""
    points = 2 * round((ts / channel.ts - 1) / 2) + 1
    values = channel.values
    if points > 1:
        values = uniform_filter1d(values, points, axis=0, mode="nearest")
    return np.column_stack([np.interp(time, channel.time, v) for v in values.T])

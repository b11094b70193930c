"""Angles without the wandering of noise, for what remembers every turn: the hysteresis.

A Dahl state forgets by the way that its angle has gone. Noise of 2 urad at 4 kHz goes 9 mrad a
second, more than half of a hysteresis' width, and so a model fed with raw angles forgets while
the machine stands still. The play operator (a shaft that moves another through a gap) follows
the motion and leaves that way out; at a reversal it is late by the gap, some sigma of the noise.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
ORDER, GAIN = 6, 924.0
"""Differences of this order keep white noise, its variance times the gain, and no motion."""
KEPT = 0.95
"""Share of the differences that counts: what a shock or a broken sample makes is left out."""
ROUNDING = 1e-12
"""Gaps between angles that are nothing but the rounding of numbers, relative."""
REACH = 4.0
"""Half the gap, in standard deviations of the noise."""


def angle_noise(theta: Array) -> Array:
    """Standard deviation (n,) [rad] of the white noise in evenly sampled angles (samples, n).

    No less than what an encoder's step makes; zero for fewer than eight samples.
    """
    if len(theta) < ORDER + 2:
        return np.zeros(theta.shape[1])
    squares = np.sort(np.diff(theta, ORDER, axis=0) ** 2, axis=0)
    kept = squares[: max(1, int(KEPT * len(squares)))]
    noise = np.sqrt(kept.mean(axis=0) / GAIN)
    return np.asarray(np.maximum(noise, encoder_step(theta) / np.sqrt(12.0)))


def encoder_step(theta: Array) -> Array:
    """Step (n,) [rad] of which all angles (samples, n) are multiples, but for an offset; else 0."""
    return np.array([_step(angle) for angle in theta.T])


def _step(angle: Array) -> float:
    levels = np.unique(angle)
    gaps = np.diff(levels)
    gaps = gaps[gaps > ROUNDING * np.abs(levels).max(initial=0.0)]
    if len(gaps) == 0:
        return 0.0
    # a bridged sample lies anywhere: hence not the smallest gap of all
    step = float(np.quantile(gaps, 0.05))
    away = (levels - levels[len(levels) // 2]) / step
    return step if (np.abs(away - np.round(away)) < 0.05).mean() > 0.9 else 0.0


def play(theta: Array, half: Array) -> Array:
    """Angles (samples, n) behind a gap of +-half (n,) [rad], which begins in its middle."""
    low, high = theta - half, theta + half
    followed = np.empty_like(theta)
    now = theta[0]
    for k in range(len(theta)):
        now = np.minimum(np.maximum(now, low[k]), high[k])
        followed[k] = now
    return followed

"""Angles without the wandering of noise, for what remembers every turn: friction and hysteresis.

A Dahl state forgets by the way that its angle has gone. Noise of 2 urad at 4 kHz goes 9 mrad a
second, more than half of a hysteresis' width, and so a model fed with raw angles forgets while
the machine stands still. Only reversals beyond the noise count, at the instant at which the angle
was extreme: the hysteresis filter of rainflow counting (ASTM E1049). A play operator would leave
that way out as well, but turn late by its gap.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Index = NDArray[np.intp]
ORDER, GAIN = 6, 924.0
"""Differences of this order keep white noise, its variance times the gain, and no motion."""
KEPT = 0.95
"""Share of the differences that counts: what a shock or a broken sample makes is left out."""
ROUNDING = 1e-12
"""Gaps between angles that are nothing but the rounding of numbers, relative."""
NEAR, FEW = 0.05, 10.0
"""Share of a step by which an angle may miss its place; steps that one tells well enough."""
REACH = 10.0
"""Smallest way back that counts, in standard deviations of the noise: 20 000 samples of noise alone
hardly go that far."""


def angle_noise(theta: Array) -> Array:
    """Standard deviation (n,) [rad] of the white noise in evenly sampled angles (samples, n).

    No less than what an encoder's step makes; zero for fewer than eight samples.
    """
    if len(theta) < ORDER + 2:
        return np.zeros(theta.shape[1])
    squares = np.diff(theta, ORDER, axis=0) ** 2
    count = max(1, int(KEPT * len(squares)))
    noise = np.sqrt(np.partition(squares, count - 1, axis=0)[:count].mean(axis=0) / GAIN)
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
    off = levels - levels[len(levels) // 2]
    reach = FEW * step
    while reach < FEW * np.ptp(off):
        # numbers of a file are rounded: only far levels tell the step well enough for the stroke
        near = off[np.abs(off) <= reach]
        count = np.round(near / step)
        if count.any():
            step = float(count @ near / (count @ count))
        reach *= FEW
    away = off / step
    return step if (np.abs(away - np.round(away)) < NEAR).mean() > 0.9 else 0.0


def hysteresis_filter(theta: Array, noise: Array) -> Array:
    """Angles (samples, n) that turn only where they go back by more than `REACH` times their noise
    (n,) [rad], as a standard deviation; between these reversals they are monotone.

    Where an encoder shows its last step for a while, the angle turns in the middle of it.
    """
    filtered = [_monotone(angle, sigma) for angle, sigma in zip(theta.T, noise, strict=True)]
    return np.stack(filtered, axis=1)


def turning(theta: Array, noise: Array) -> Array:
    """How much later than its sample an angle turned (samples, n), in samples, -0.5 to 0.5: by the
    parabola through its neighbours, or the middle of equally extreme ones. Zero elsewhere."""
    lateness = np.zeros_like(theta)
    for i, sigma in enumerate(noise):
        for first, last, _ in _reversals(theta[:, i], REACH * sigma):
            k = (first + last) // 2
            lateness[k, i] = (first + last) / 2 - k
            if first == last and 0 < k < len(theta) - 1:
                before, now, after = theta[k - 1 : k + 2, i]
                bend = before - 2 * now + after
                lateness[k, i] = (before - after) / (2 * bend) if bend else 0.0
    return np.clip(lateness, -0.5, 0.5)


@dataclass(frozen=True)
class Held:
    """Samples (k,) in which an angle shows nothing of its turn: each the last one before that, the
    first one after it, and how far it is from that one to this one, 0 to 1."""

    samples: Index
    before: Index
    after: Index
    share: Array


def held(theta: Array, noise: Array) -> list[Held]:
    """Of each angle, where an encoder shows its last step for a while."""
    listed = list[Held]()
    for angle, sigma in zip(theta.T, noise, strict=True):
        ends = [(a, b) for a, b, _ in _reversals(angle, REACH * sigma) if b > a]
        first, last = np.array(ends, dtype=np.intp).reshape(-1, 2).T
        last = np.minimum(last + 1, len(angle) - 1)
        length = last - first
        before, after = np.repeat(first, length), np.repeat(last, length)
        samples = np.arange(len(before)) - np.repeat(np.cumsum(length) - length, length) + before
        listed.append(Held(samples, before, after, (samples - before) / (after - before)))
    return listed


def _monotone(angle: Array, sigma: float) -> Array:
    out, way, start = np.empty_like(angle), 0, 0
    turns = _reversals(angle, REACH * sigma)
    for _, turn, next_way in [*turns, (0, len(angle) - 1, 0)]:
        way = way or -next_way or 1
        out[start : turn + 1] = way * np.maximum.accumulate(way * angle[start : turn + 1])
        start, way = turn, next_way
    for first, last, next_way in turns:
        half = (last - first) / 2
        if half:
            away = np.abs(np.arange(first, last + 1) - (first + last) / 2)
            out[first : last + 1] -= next_way * sigma * (1 - away / half)
    return out


def _reversals(angle: Array, least: float) -> list[tuple[int, int, int]]:
    """First and last of the equally extreme samples at which an angle turns to go back by more than
    the least way, and its way from there: 1 up, -1 down."""
    reversals, way = list[tuple[int, int, int]](), 0
    # of the highest and the lowest angle since the last turn: value, first sample, last sample
    high = low = (float(angle[0]), 0, 0)
    # between two of these the angle goes one way, or stands still
    step = np.sign(np.diff(angle, prepend=np.nan, append=np.nan))
    ends = np.flatnonzero(step[1:] != step[:-1])
    for k, value in zip(ends.tolist(), angle[ends].tolist(), strict=True):
        if value >= high[0]:
            high = (value, k if value > high[0] else high[1], k)
        if value <= low[0]:
            low = (value, k if value < low[0] else low[1], k)
        if way >= 0 and high[0] - value > least:
            reversals.append((*high[1:], -1))
            way, low = -1, (value, k, k)
        elif way <= 0 and value - low[0] > least:
            reversals.append((*low[1:], 1))
            way, high = 1, (value, k, k)
    return reversals

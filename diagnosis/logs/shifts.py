"""By how much one signal is later than another one, if they are the same.

shift = argmin_s  rms(a(t) - b(t + s))       correlation first, then Gauss-Newton in s
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft

from flexhex.diagnosis.logs.log import COARSE, POINTS, Array, Channel

OVERLAP = 0.5
"""Part of the shorter run that must lie on the other."""
STEPS, CLOSE = 8, 1e-4
"""Most steps to the best shift, and how small the last one is, in samples."""
FEW, LIKELY = 1000, 2.0
"""Samples that tell another motion, by a difference of so many times the largest of two passes."""
NEAR = 20
"""Samples beside a coarse minimum among which the best is taken."""


def shift_of(a: Channel, b: Channel, alike: float, close: float = CLOSE) -> float | None:
    """Shift [s] so that b(t + shift) = a(t), to a fraction of a sample; None when unlike.

    alike: largest rms(a - b) / rms(a) over the overlap; close: last step, in samples.
    """
    first, second = a.coarse, b.coarse
    if min(len(first), len(second)) < 4 or not first.any() or not second.any():
        return None
    lag = _lag(first, second)
    shift = b.t0 - a.t0 + lag * COARSE
    # a few samples tell most other motions, and all of them how late the same one is
    for points, most in ((FEW, LIKELY * alike), (POINTS, alike)):
        settled = _settled(a, b, shift, points, close)
        if settled is None or settled[1] >= most:
            return None
        shift = settled[0]
    return shift


def _settled(
    a: Channel, b: Channel, shift: float, points: int, close: float
) -> tuple[float, float] | None:
    """The best shift near this one, and the relative difference there; None without overlap."""
    for _ in range(STEPS):
        step, apart = nearer(a, b, shift, points)
        if step is None or apart is None:
            return None
        shift += step
        if abs(step) < close * min(a.ts, b.ts):
            return shift, apart
    _, apart = nearer(a, b, shift, points)
    return None if apart is None else (shift, apart)


def _lag(a: Array, b: Array) -> int:
    """Samples by which b is later than a, where they differ least over enough overlap."""
    # sum |a - b|^2 over the overlap = energy of both parts - 2 correlation
    cross = correlated(b, a)
    lags = np.arange(-len(a) + 1, len(b))
    energy_a = np.concatenate([[0.0], np.cumsum((a**2).sum(axis=1))])
    energy_b = np.concatenate([[0.0], np.cumsum((b**2).sum(axis=1))])
    begin, end = np.maximum(0, -lags), np.minimum(len(a), len(b) - lags)
    total = energy_a[end] - energy_a[begin] + energy_b[end + lags] - energy_b[begin + lags]
    enough = end - begin >= OVERLAP * min(len(a), len(b))
    apart = np.where(enough, (total - 2 * cross) / np.maximum(total, 1e-30), np.inf)
    # a motion that repeats within a run fits at several lags: the smallest of them
    equal = np.flatnonzero(apart <= apart.min() + 1e-3)
    best = equal[np.argmin(np.abs(lags[equal]))]
    near = np.abs(np.arange(len(lags)) - best) <= NEAR
    return int(lags[np.argmin(np.where(near, apart, np.inf))])


def correlated(a: Array, b: Array) -> Array:
    """Sum over columns of a[k + lag] b[k], a (samples, n), b (others, n), at lags from 1 - others
    to samples - 1."""
    size = len(a) + len(b) - 1
    long = next_fast_len(size, real=True)
    spectrum = (rfft(a, long, axis=0) * rfft(b, long, axis=0).conj()).sum(axis=1)
    return np.asarray(np.roll(irfft(spectrum, long), len(b) - 1)[:size])


def _place(b: Channel, at: Array) -> Array:
    """Where instants [s] lie among the samples of a channel; beyond both ends none is inside."""
    if not b.breaks:
        return (at - b.t0) / b.ts
    return np.interp(at, b.time, np.arange(len(b.values)))


def nearer(
    a: Channel, b: Channel, shift: float, points: int = POINTS
) -> tuple[float | None, float | None]:
    """Step towards the best shift, and the relative difference at this one, by about so many
    points."""
    every = slice(None, None, max(1, len(a.values) // points))
    place = _place(b, a.time[every] + shift)
    inside = a.valid[every] & (place >= 1) & (place <= len(b.values) - 2)
    # one place between two samples serves all columns, a sample before and after it, too
    first = np.clip(place.astype(int), 1, len(b.values) - 3)
    trusted = b.valid[first] & b.valid[first + 1]
    kept = np.flatnonzero(inside & trusted)
    if len(kept) < 8:
        return None, None
    place, first, wanted = place[kept], first[kept], a.values[every][kept]
    share = (place - first)[:, None]
    values = [b.values.take(first + k, axis=0) for k in (-1, 0, 1, 2)]
    before, moved, after = (one + share * (two - one) for one, two in pairwise(values))
    slope, apart = (after - before) / (2 * b.ts), wanted - moved
    if not (slope**2).sum() > 0:
        return None, None
    # an offset between passes is no difference of motion
    apart = apart - apart.mean(axis=0)
    size = float(np.sqrt(((wanted - wanted.mean(axis=0)) ** 2).mean()))
    step = float((slope * apart).sum() / (slope**2).sum())
    limit = 2 * COARSE
    return max(-limit, min(limit, step)), float(np.sqrt((apart**2).mean())) / max(size, 1e-30)

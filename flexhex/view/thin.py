"""Fewer samples for a page: bins that keep their extremes, instants for the machine; as text."""

from __future__ import annotations

import base64
from dataclasses import dataclass

import numpy as np

from flexhex.ssp.result import Array, Group


@dataclass(frozen=True)
class Line:
    """One scalar for a plot: point k stands at t0 + k step [s].

    values (n,): the samples; or, where `bin` is the samples of a bin (more than 1), the extremes
    of each bin, two points in the order in which they occur.
    """

    t0: float
    step: float
    values: Array
    bin: int = 1


def line(t0: float, ts: float, samples: Array, points: int) -> Line:
    """At most `points` points (even, at least 2) of samples (n,) that are ts [s] apart.

    A signal that never changes is two points. The last bin may hold fewer samples than the others.
    """
    n = len(samples)
    if n > 2 and not np.any(samples != samples[0]):
        return Line(t0, (n - 1) * ts, samples[[0, -1]])
    if n <= points:
        return Line(t0, ts, samples)
    size = -(-n // (points // 2))
    full = n // size
    body = samples[: full * size].reshape(full, size)
    pairs = [_extremes(body)]
    if full * size < n:
        pairs.append(_extremes(samples[None, full * size :]))
    return Line(t0, size * ts / 2, np.concatenate(pairs).ravel(), size)


def _extremes(bins: Array) -> Array:
    """Lowest and highest value of each row (bins, 2), the earlier one first."""
    low, high = bins.argmin(axis=1), bins.argmax(axis=1)
    rows = np.arange(len(bins))
    return np.stack([bins[rows, np.minimum(low, high)], bins[rows, np.maximum(low, high)]], axis=1)


def instants(group: Group, begin: float, end: float, most: int) -> Array:
    """At most `most` sample times [s] of a group in begin to end, evenly apart."""
    first, last = rows(group, begin, end)
    stride = max(1, -(-(last - first) // most))
    return np.asarray(group.time[first:last:stride])


def rows(group: Group, begin: float, end: float) -> tuple[int, int]:
    """First row of a group at or after begin [s], and the one behind the last until end."""
    slack = 1e-6
    first = int(np.ceil(begin / group.Ts - slack))
    last = int(min(np.floor(end / group.Ts + slack), group.rows - 1))
    return max(0, first), last + 1


def zero_order_hold(group: Group, samples: Array, times: Array) -> Array:
    """What others see at those times [s]: the latest sample (rows, ...) of each."""
    places = np.floor(times / group.Ts + 1e-6).astype(int)
    return np.asarray(samples[np.clip(places, 0, len(samples) - 1)])


def packed(values: Array) -> str:
    """Base64 of little-endian float32, row by row."""
    return base64.b64encode(np.ascontiguousarray(values, dtype="<f4").tobytes()).decode("ascii")

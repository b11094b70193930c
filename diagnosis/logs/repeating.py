"""The longest part of a signal that is one motion, again and again; and where a motion rests."""

from __future__ import annotations

import numpy as np

from flexhex.diagnosis.logs.log import COARSE, Array

THIN = 3000
"""Samples that are compared at each lag, about. This number and the next two, each halved or
doubled, leave the passes of eight logs as they are: one motion, two in turn, short moves."""
MOVES = 0.01
"""Share of the whole signal's mean square that a part has at least, or nothing moves in it."""
STILL = 0.01
"""Change within half a rest, relative to the signal (RMS), below which an axis rests."""


def repeating(values: Array, alike: float, shortest: float) -> tuple[int, int] | None:
    """First and last sample of the longest part of a signal (samples, n) in which it is what it was
    a lag before, for a lag and more; None where there is none.

    alike: largest difference, relative to the signal (RMS); shortest: least lag [s]. Of lags at
    which parts are about as long, the shortest.
    """
    count, step = len(values), max(1, len(values) // THIN)
    squares = (values**2).sum(axis=1)
    most, best, longest = alike**2 * float(squares.mean()), None, 0
    for lag in range(max(step, round(shortest / COARSE)), count // 2 + 1):
        apart = ((values[lag::step] - values[: count - lag : step]) ** 2).sum(axis=1)
        first, last = _longest(apart <= most)
        first, last = step * first, step * last
        if last - first < lag or last + lag - first <= longest * (1 + alike):
            continue
        if squares[first:last].mean() < MOVES * squares.mean():
            continue
        best, longest = (first, last + lag), last + lag - first
    return best


def _longest(there: Array) -> tuple[int, int]:
    """Begin and end of the longest stretch of true values."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], there.astype(np.int8), [0]])))
    if not len(edges):
        return 0, 0
    k = int(np.argmax(edges[1::2] - edges[::2]))
    return int(edges[2 * k]), int(edges[2 * k + 1])


def rests(values: Array, length: float) -> list[int]:
    """The middles of the rests of a signal (samples, n) that last so long [s]."""
    half = max(1, round(length / COARSE / 2))
    moved = np.abs(values[half:] - values[:-half]) if len(values) > half else values[:0]
    still = (moved <= STILL * np.sqrt((values**2).mean(axis=0).max())).all(axis=1)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], still.astype(np.int8), [0]])))
    pairs = zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)
    return [(a + b + half) // 2 for a, b in pairs if b - a >= half]

"""One Hann window for everything, evaluated where it is wanted: at any instant, on any clock.

Channels with clocks of their own are never resampled: each is averaged under the same window in
continuous time, at the same instants.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

Array = NDArray[np.float64]
FILLED = 0.9
"""Share of the window's weight that must lie on valid samples."""
SAMPLES = 24
"""Samples of a window that give a mean over it. Half as many change what is found of the hexapod
and of the axis of the benchmark by less than 0.2 %, but put a mode beyond the motion out of its
interval (`test_calmest.py`) and bend friction that sticks (`test_sticks.py`)."""


def hann_weights(
    at: Array, t0: float, ts: float, valid: NDArray[np.bool_], window: float
) -> tuple[csr_array, NDArray[np.bool_]]:
    """Weights (instants, samples), rows of unit sum, and where the window is filled (instants,).

    at: instants [s]; t0, ts, valid (samples,): clock of a channel; window: full length [s], at
    least three samples are taken.
    """
    window = max(window, 4.0 * ts)
    centre, length = (at - t0) / ts, window / ts
    first = np.floor(centre - length / 2).astype(int) + 1
    index = first[:, None] + np.arange(int(np.ceil(length)))
    weight = _hann(first - centre, index.shape[1], length)
    total = weight.sum(axis=1)
    place = np.clip(index, 0, len(valid) - 1)
    weight *= (place == index) & valid[place]
    kept = weight.sum(axis=1)
    filled = kept > FILLED * total
    weight /= np.maximum(kept, 1e-300)[:, None]
    weight[~filled] = 0.0
    ends = index.shape[1] * np.arange(len(at) + 1)
    matrix = csr_array((weight.ravel(), place.ravel(), ends), shape=(len(at), len(valid)))
    return matrix, filled


def _hann(first: Array, count: int, length: float) -> Array:
    """The window (instants, count) of a length, at places from `first` (instants,) on, one apart,
    from its middle; zero outside, where the last place alone may be.

    (1 + cos(first + k)) / 2 with the cosine of the sum: there are far more places than cosines.
    """
    turn = 2.0 * np.pi / length
    begins, steps = turn * first, turn * np.arange(count)
    rows = np.stack([np.cos(begins), -np.sin(begins), np.ones(len(first))], axis=1)
    weight = rows @ np.stack([np.cos(steps), np.sin(steps), np.ones(count)]) / 2.0
    weight[first + (count - 1) >= length / 2, -1] = 0.0
    return np.asarray(np.maximum(weight, 0.0, out=weight))


def enough(window: float, ts: float) -> int:
    """One of how many samples is enough for a mean over a window [s]."""
    return max(int(window / SAMPLES / ts), 1)


@dataclass(frozen=True)
class Few:
    """Means of so many neighbours of the samples that lie in windows, in which noise counts no more
    than in all samples; weights (m, few) of these means; places: of the samples, a slice where
    there are no others between, as it is no copy; starts: first of each mean among these, which
    ends at a gap."""

    places: NDArray[np.int64] | slice
    every: int
    weights: csr_array
    starts: NDArray[np.int64]

    @staticmethod
    def of(weights: csr_array, every: int) -> Few:
        """weights (m, samples): of all."""
        places = np.unique(weights.indices[weights.data > 0])
        count = len(places)
        edges = [0, *(np.flatnonzero(np.diff(places) > 1) + 1), count]
        starts = np.concatenate([np.arange(a, b, every) for a, b in pairwise(edges)])
        mean = np.repeat(np.arange(len(starts)), np.diff(np.append(starts, count)))
        shape = count, len(starts)
        member = csr_array((np.ones(count), mean, np.arange(count + 1)), shape=shape)
        some = places if len(edges) > 2 or not count else slice(places[0], places[-1] + 1)
        return Few(some, every, csr_array(weights[:, some] @ member), starts)

    def __call__(self, raw: Array) -> Array:
        """These means (few, ...) of anything on the same clock (samples, ...)."""
        some = raw[self.places]
        if self.every == 1 or not len(some):
            return some
        counts = np.diff(np.append(self.starts, len(some))).reshape(-1, *[1] * (raw.ndim - 1))
        return np.asarray(np.add.reduceat(some, self.starts, axis=0) / counts)

    def smooth(self, means: Array) -> Array:
        """Windows (m, k) of means (few, k)."""
        return np.asarray(self.weights @ means)

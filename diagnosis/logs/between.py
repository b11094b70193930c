"""Values at even times, from those at uneven ones."""

from __future__ import annotations

import numpy as np

from flexhex.diagnosis.logs.log import Array, Channel, Mask

FEWEST = 3
WIDEST = 2.5
"""A step of more periods than this is a gap: one sample may be late or missing. Doubled it changes
nothing on a Panda's log with such times; halved most of its rows lie near a gap and are lost."""
PIECE, REACH = 100_000, 8
"""Samples that are interpolated at once, and beyond them, for what their neighbours say."""


def between(t: Array, values: Array, t0: float, ts: float, size: int) -> Channel:
    """Values (samples, width), which may hold NaN, at t0 + k ts from those at the times t: cubic
    between neighbours. Within gaps NaN; invalid where no sample was recorded, not for a NaN."""
    from scipy.interpolate import Akima1DInterpolator  # takes long to load

    out = np.full((size, values.shape[1]), np.nan)
    finite = np.flatnonzero(np.isfinite(values).all(axis=1))
    known = t[finite]
    for begin in range(0, size, PIECE):
        grid: Array = t0 + ts * np.arange(begin, min(begin + PIECE, size), dtype=np.float64)
        low, high = np.searchsorted(known, grid[[0, -1]])
        near = finite[max(low - REACH, 0) : high + REACH]
        inside = _near(t[near], grid, ts)
        if inside.any():
            curve = Akima1DInterpolator(t[near], values[near], method="makima")
            out[begin : begin + len(grid)][inside] = curve(grid[inside], extrapolate=True)
    grid = t0 + ts * np.arange(size, dtype=np.float64)
    return Channel(t0, ts, out, _near(t, grid, ts))


def _near(t: Array, grid: Array, ts: float) -> Mask:
    """Whether there is no gap about each time of the grid, nor one sample farther, whose slope
    would know nothing of what it spans."""
    if len(t) < FEWEST:
        return np.zeros(len(grid), dtype=bool)
    after = np.clip(np.searchsorted(t, grid), 1, len(t) - 1)
    off = np.maximum(t[0] - grid, grid - t[-1]) <= 0.5 * ts
    whole = np.pad(np.diff(t) <= WIDEST * ts, 1, mode="edge")
    return np.asarray((whole[:-2] & whole[1:-1] & whole[2:])[after - 1] & off)

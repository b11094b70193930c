"""Orders of the angle that the rows can show, and those of them at which most is left."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.selection.rows import Rows

Array = NDArray[np.float64]
PERIODS, PER_WINDOW = 1.5, 1.0
"""Least periods over the stroke: fewer look like a spring. Most periods within the smoothing window
at a slow rate: more are averaged out."""
SLOW = 0.1
"""Share of the rows that are slower than what is called slow."""
FINER, BINS = 4, 4
"""Points of the spectrum between two orders that the stroke tells apart; bins of the angle in the
shortest period."""
TRIED = 120
"""Orders that are tried in full."""
HARMONIC = 0.05
"""Distance from a whole multiple of another order within which one is its harmonic."""


def fundamentals(orders: Sequence[float]) -> list[float]:
    """Orders of which the others are harmonics, the lowest first."""
    found = list[float]()
    for order in sorted(orders):
        if not any(abs(order / f - round(order / f)) < HARMONIC for f in found):
            found.append(order)
    return found


def promising_orders(
    rows: Rows, axis: int, weight: Sequence[Array] | None = None
) -> tuple[list[float], int]:
    """Orders [1/rad] with the largest amplitude in what the base model leaves of an axis' torque,
    in their order, and how many there are to choose from.

    weight (samples, n) of each block: amplitudes are of the residual times this.
    """
    made, base = rows.made, rows.made.base
    pairs = [(b, b.run.motion) for b in made.blocks]
    angle = rows.raw([b.smooth(m.theta[:, axis]) for b, m in pairs])
    rate = np.abs(rows.raw([b.smooth(m.thetad[:, axis]) for b, m in pairs]))
    left = rows.y[axis] - rows.B[axis] @ made.regression.q
    if weight is not None:
        loaded = [b.smooth(w[:, axis]) for (b, _), w in zip(pairs, weight, strict=True)]
        left = left * rows.raw(loaded)
    stroke = float(np.ptp(angle))
    slow = max(float(np.quantile(rate, SLOW)), 1e-9 * stroke / base.window)
    low = 2 * np.pi * PERIODS / stroke
    high = max(2 * np.pi * PER_WINDOW / (slow * base.window), 2 * low)
    count = int(min(np.ceil(BINS * stroke * high / (2 * np.pi)), len(angle) * BINS))
    place = np.minimum((angle - angle.min()) / stroke * count, count - 1).astype(int)
    filled = np.bincount(place, minlength=count)
    level = np.bincount(place, left, count) / np.maximum(filled, 1)
    spectrum = np.abs(np.fft.rfft(np.where(filled > 0, level, 0.0), FINER * count))
    orders = 2 * np.pi / (FINER * stroke) * np.arange(len(spectrum))
    there = np.flatnonzero((orders >= low) & (orders <= high))
    best = there[np.argsort(-spectrum[there])[:TRIED]]
    return sorted(float(order) for order in orders[best]), len(there)

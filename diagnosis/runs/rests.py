"""Where an axis rests: there dry friction carries any torque up to its own, so that a row says
nothing about the model."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import label, maximum_filter1d

from flexhex.diagnosis.basemodels.base import Motion
from flexhex.diagnosis.reversals import REACH

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
SLOW = 0.05
"""Rate, relative to its RMS, below which an axis may rest."""
TRAVEL = 0.01
"""Way, relative to the stroke, within which an axis that is slow rests; beyond it, it creeps on
purpose."""
TURN = 3.0
"""Times that a reversal at the RMS acceleration takes, beyond which an axis that is slow, or whose
angle does not change, rests."""

PART = 0.25
"""Share of a row's smoothing in which an axis sticks, beyond which the row says nothing. 0, 0.1 and
0.25 give the same names and the same friction within 0.2 % (belt axis, 5 um steps); reversals that
are averaged over, as of slow drifts, stay below."""


def moving(
    motions: Sequence[tuple[Array, Array, Array]],
    usable: Sequence[Mask],
    window: float,
    spacing: float,
) -> list[Mask]:
    """Rows (m, n) of each run in which an axis moves; motions: smoothed angles, rates and
    accelerations (m, n) of each, usable (m,).

    It rests where it is slow for longer than it takes to turn, and stays at its place meanwhile; a
    row whose smoothing window [s] reaches into such a time says nothing either. spacing: time
    between rows [s].
    """
    angles, rates, paces = zip(*motions, strict=True)
    seen = [
        np.concatenate([v[good] for v, good in zip(values, usable, strict=True)])
        for values in (angles, rates, paces)
    ]
    rate, pace = (np.sqrt((values**2).mean(axis=0)) for values in seen[1:])
    slow, near = SLOW * rate, TRAVEL * np.ptp(seen[0], axis=0)
    turn = TURN * 2 * slow / np.maximum(pace, np.finfo(float).tiny)
    width = 2 * int(np.ceil(window / spacing / 2)) + 1
    moving_rows = list[Mask]()
    for speed, angle in zip(rates, angles, strict=True):
        still = maximum_filter1d(np.abs(speed), width, axis=0) < slow
        for i in range(still.shape[1]):
            numbers, count = label(still[:, i])
            for k in range(1, count + 1):
                rows = numbers == k
                short = rows.sum() * spacing + window < turn[i]
                if short or np.ptp(angle[rows, i]) > near[i]:
                    still[rows, i] = False
        moving_rows.append(~maximum_filter1d(still, 2 * width + 1, axis=0))
    return moving_rows


def sticking(motion: Motion, pace: Array, window: float) -> Mask:
    """Samples (samples, n) in which an axis sticks: its angle shows no way back, or a small one, as
    of a reversal, for longer than a reversal of that way takes at a pace (n,) of acceleration.

    Feedback needs a while to bring the torque to the other side of dry friction, and the axis
    stands still or creeps meanwhile. Smoothed rates show that only if it takes longer than their
    window [s].
    """
    noise = np.zeros_like(pace) if motion.noise is None else motion.noise
    stuck = np.zeros(motion.theta.shape, dtype=bool)
    for i in np.flatnonzero(pace > 0):
        angle, near = motion.theta[:, i], REACH * noise[i]
        while True:
            turn = TURN * 2 * np.sqrt(2 * near / pace[i])
            width = 2 * max(int(np.ceil(turn / motion.ts / 2)), 1) + 1
            still = maximum_filter1d(angle, width) + maximum_filter1d(-angle, width) <= near
            stuck[:, i] |= maximum_filter1d(still, width)
            if not 0 < turn < window:
                break
            near *= 2
    return stuck

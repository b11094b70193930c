"""Where an axis rests: there dry friction carries any torque up to its own, so that a row says
nothing about the model."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import label, maximum_filter1d

from flexhex.diagnosis.blocks import Block

SLOW = 0.05
"""Rate, relative to its RMS, below which an axis may rest."""
TRAVEL = 0.01
"""Way, relative to the stroke, within which an axis that is slow rests; beyond it, it creeps on
purpose."""


def moving(blocks: Sequence[Block], window: float, spacing: float) -> list[NDArray[np.bool_]]:
    """Rows (m, n) of each block in which an axis moves.

    It rests where it is slow throughout a smoothing window [s] and stays at its place meanwhile;
    spacing: time between rows [s]. An oscillation passes through zero and does not rest.
    """
    rates = [block.smooth(block.run.motion.thetad) for block in blocks]
    angles = [block.smooth(block.run.motion.theta) for block in blocks]
    seen = [
        np.concatenate([v[b.usable] for v, b in zip(x, blocks, strict=True)])
        for x in (rates, angles)
    ]
    slow, near = SLOW * np.sqrt((seen[0] ** 2).mean(axis=0)), TRAVEL * np.ptp(seen[1], axis=0)
    width = 2 * int(np.ceil(window / spacing / 2)) + 1
    found = []
    for rate, angle in zip(rates, angles, strict=True):
        still = maximum_filter1d(np.abs(rate), width, axis=0) < slow
        for i in range(rate.shape[1]):
            numbers, count = label(still[:, i])
            for k in range(1, count + 1):
                rows = numbers == k
                if np.ptp(angle[rows, i]) > near[i]:
                    still[rows, i] = False
        found.append(~still)
    return found

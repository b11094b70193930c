"""Where an axis rests: there dry friction carries any torque up to its own, so that a row says
nothing about the model."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import label, maximum_filter1d

if TYPE_CHECKING:
    from flexhex.diagnosis.runs.blocks import Block

SLOW = 0.05
"""Rate, relative to its RMS, below which an axis may rest."""
TRAVEL = 0.01
"""Way, relative to the stroke, within which an axis that is slow rests; beyond it, it creeps on
purpose."""
TURN = 3.0
"""Times that a reversal at the RMS acceleration takes, beyond which an axis that is slow rests."""


def moving(blocks: Sequence[Block], window: float, spacing: float) -> list[NDArray[np.bool_]]:
    """Rows (m, n) of each block in which an axis moves.

    It rests where it is slow for longer than it takes to turn, and stays at its place meanwhile; a
    row whose smoothing window [s] reaches into such a time says nothing either. spacing: time
    between rows [s].
    """
    names = ("theta", "thetad", "thetadd")
    smooth = {x: [b.smooth(getattr(b.run.motion, x)) for b in blocks] for x in names}
    seen = {
        x: np.concatenate([v[b.usable] for v, b in zip(values, blocks, strict=True)])
        for x, values in smooth.items()
    }
    rate, pace = (np.sqrt((seen[x] ** 2).mean(axis=0)) for x in ("thetad", "thetadd"))
    slow, near = SLOW * rate, TRAVEL * np.ptp(seen["theta"], axis=0)
    turn = TURN * 2 * slow / np.maximum(pace, np.finfo(float).tiny)
    width = 2 * int(np.ceil(window / spacing / 2)) + 1
    moving_rows = []
    for speed, angle in zip(smooth["thetad"], smooth["theta"], strict=True):
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

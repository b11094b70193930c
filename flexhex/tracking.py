"""Tracking error and feedback torque of a run, the figures of [SH, Table I] for any result.

RMS over all joints and samples after the settling time; a run that ends before is judged whole.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from flexhex.ssp.result import Array, Result

SETTLE = 2.0
"""Time before the first move [s]: the preload's transient is over, nothing is judged."""
ERROR, TORQUE = "feedback.e", "feedback.tau_fb"
MICRO = 1e6


@dataclass(frozen=True)
class Tracking:
    """Figures of one run, judged from begin to end [s].

    e: RMS tracking error [µrad]; e_max: its largest magnitude [µrad], of which joint (from 1)
    and at what time [s]; tau_fb: RMS feedback torque [N m], NaN when it was not logged.
    """

    begin: float
    end: float
    e: float
    e_max: float
    joint: int
    at: float
    tau_fb: float


def tracking(result: Result, end: float = math.inf) -> Tracking | None:
    """Figures of a result up to `end` [s]; None when it holds no `feedback.e`."""
    if ERROR not in result:
        return None
    time, e = result.time(ERROR), columns(result[ERROR])
    judged = _judged(time, end)
    if not judged.any():
        return None
    kept, instants = np.abs(e[judged]), time[judged]
    row, joint = np.unravel_index(int(np.argmax(kept)), kept.shape)
    torque = math.nan
    if TORQUE in result:
        torque = rms(result[TORQUE][_judged(result.time(TORQUE), end)])
    return Tracking(
        begin=SETTLE if instants[0] > SETTLE else float(instants[0]),
        end=float(instants[-1]),
        e=rms(kept) * MICRO,
        e_max=float(kept[row, joint]) * MICRO,
        joint=int(joint) + 1,
        at=float(instants[row]),
        tau_fb=torque,
    )


def _judged(time: Array, end: float) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    """Which samples count: after the settling time, or all of a run that is shorter."""
    until = time <= end + 1e-9
    late = until & (time > SETTLE)
    return late if late.any() else until


def rms(values: Array) -> float:
    """Root of the mean square of all entries."""
    return float(np.sqrt(np.mean(np.square(values))))


def columns(values: Array) -> Array:
    """Samples (n,) or (n, size) as (n, columns)."""
    return values.reshape(len(values), -1)

"""What the page of a diagnosis draws."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Candidate:
    """How a hypothesis did in one round: axis and shape, and what it predicts.

    gain: what it adds to the log density of left-out trajectories [nats]; size: RMS of its torque
    beyond what the base model takes up, relative to that of the axis.
    """

    round: int
    id: str
    axes: tuple[int, ...]
    shape: Mapping[str, float]
    gain: float
    size: float
    chosen: bool = False
    rival: bool = False


@dataclass(frozen=True)
class Map:
    """Repeating residual [`residual`] of an axis over one quantity [unit], before and after.

    centre (bins,), before, after (bins,): means; spread (bins,): standard error of a mean.
    """

    axis: int
    over: str
    unit: str
    centre: Array
    before: Array
    after: Array
    spread: Array
    residual: str = "N m"


@dataclass(frozen=True)
class Strip:
    """Torque of an axis (from 1) in one run over time (m,) [s], in `unit`; held_out: nothing was
    fitted to the run.

    measured, and what the model says before and after what was found was added (m,); NaN where the
    log has a gap.
    """

    run: str
    held_out: bool
    axis: int
    unit: str
    time: Array
    measured: Array
    before: Array
    after: Array

"""One run as the diagnosis sees it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Motion

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class TimeSeries:
    """Values (samples, n) at t0 + k ts [s]; valid (samples,)."""

    t0: float
    ts: float
    values: Array
    valid: Mask

    @cached_property
    def spread(self) -> tuple[int, Array, Array]:
        """How many samples are valid, their mean (n,) and variance (n,)."""
        values, count = self.values[self.valid], int(self.valid.sum())
        mean = values.sum(axis=0) / max(count, 1)
        return count, mean, ((values - mean) ** 2).sum(axis=0) / max(count, 1)


@dataclass(frozen=True)
class Run:
    """One run as the diagnosis sees it.

    trajectory: the motion; runs that share it and carry the same are its passes; shift [s]: run
    time minus the time that runs of one motion share; start [s]: when it began on the machine's own
    clock, as far as the order of the runs tells; tau: torque that the drives report [N m]; command:
    what they were asked for. payload: as the log says it [kg]; loads: what was carried beside, as
    the runs themselves show it, one bit for each payload.
    """

    name: str
    trajectory: str
    motion: Motion
    valid: Mask
    tau: TimeSeries
    command: TimeSeries | None = None
    shift: float = 0.0
    start: float = 0.0
    payload: float = 0.0
    meta: Mapping[str, str] = field(default_factory=dict)
    loads: int = 0

    @property
    def repeated(self) -> tuple[str, str, int]:
        """What passes share: motion and all that was carried."""
        return self.trajectory, announced(self.payload), self.loads


def announced(payload: float) -> str:
    """A payload [kg] as it is named; the same for what differs by the digits of a log alone."""
    return f"{payload:.3g}"

"""Values that the base model is fitted about."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class FixedEffect:
    """An effect, as `hypotheses.compiled` has it, on an axis (from 0) with fixed shapes and gains
    (k,)."""

    item: Any
    axis: int
    shape: Mapping[str, float]
    gains: Array


@dataclass(frozen=True)
class Fitted:
    """Nonlinear values of the base model: widths (n,) of its curved terms, delay [s] and its
    tolerance late [s] about the one that is expected [s], and the linear ones p, gains that they
    belong to; loads: what payloads add to p, by their name. Effects of drives are linear about
    these values: lag, the time constant or delay [s] of the drive of a single axis; losses (n,), or
    0.0: shares of the reported torques that the joints do not get. effects: those that an earlier
    search found, as the torques that drives report, with which other effects go, hold theirs."""

    p: Array
    gains: Array
    widths: Array
    delay: float
    late: float
    loads: Mapping[str, Array] = field(default_factory=dict)
    expected: float = 0.0
    lag: float = 0.0
    losses: Array | float = 0.0
    effects: tuple[FixedEffect, ...] = ()

    def wider(self, before: Fitted) -> float:
        """The largest change of a width since other values, relative."""
        return float(np.abs(np.log(self.widths / before.widths)).max(initial=0.0))

    def later(self, before: Fitted) -> float:
        """The change of the delay since other values, in tolerances."""
        return abs(self.delay - before.delay) / self.late

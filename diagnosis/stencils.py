"""Central differences of fourth order."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
ENDS = 2
"""Samples at either end that have none."""


def first(values: Array, ts: float) -> Array:
    """Rates (samples - 4, ...) of values (samples, ...) every ts [s]."""
    near, far = values[3:-1] - values[1:-3], values[4:] - values[:-4]
    return np.asarray((8 * near - far) / (12 * ts))


def second(values: Array, ts: float) -> Array:
    """Accelerations (samples - 4, ...) of values (samples, ...) every ts [s]."""
    near, far = values[3:-1] + values[1:-3], values[4:] + values[:-4]
    return np.asarray((16 * near - far - 30 * values[2:-2]) / (12 * ts**2))

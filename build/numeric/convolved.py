"""Long convolutions along the first axis."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def convolved(values: Array, weights: Array) -> Array:
    """Values (samples, ...) under all of the weights (taps,): `np.convolve(..., "valid")` along the
    first axis, (samples - taps + 1, ...)."""
    from scipy.signal import oaconvolve  # takes long to load

    kernel = weights.reshape(-1, *[1] * (values.ndim - 1))
    return np.asarray(oaconvolve(values, kernel, mode="valid", axes=0))

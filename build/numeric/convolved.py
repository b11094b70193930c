"""Convolution by fast Fourier transforms, without the seconds that `scipy.signal` takes to load."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len, rfft

Array = NDArray[np.float64]


def convolved(values: Array, weights: Array) -> Array:
    """Values (samples, ...) under all of the weights (taps,): `np.convolve(..., "valid")` along the
    first axis, (samples - taps + 1, ...)."""
    size = next_fast_len(len(values), real=True)
    spectrum = rfft(weights, size).reshape(-1, *[1] * (values.ndim - 1))
    spectrum = spectrum * rfft(values, size, axis=0)
    return np.asarray(irfft(spectrum, size, axis=0)[len(weights) - 1 : len(values)])

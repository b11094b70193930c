"""One comparison for all tests: both sides, the same shape, NaN never passes."""

from __future__ import annotations

from typing import Any

import numpy as np


def assert_close(
    actual: Any, expected: Any, atol: float = 0.0, rtol: float = 0.0, what: str = "value"
) -> None:
    """Raise AssertionError unless |actual - expected| <= atol + rtol max|expected| everywhere.

    actual, expected: arrays of one shape (nothing is broadcast) and one unit; atol in that
    unit. rtol is taken of the largest expected element, so that a small element of a large
    vector may carry the vector's rounding error. NaN and infinity on either side fail. The
    message names the worst element.
    """
    a, e = np.asarray(actual, dtype=float), np.asarray(expected, dtype=float)
    if a.shape != e.shape:
        raise AssertionError(f"{what}: shape {a.shape}, expected {e.shape}")
    for side, values in (("actual", a), ("expected", e)):
        if not np.all(np.isfinite(values)):
            raise AssertionError(f"{what}: {side} holds {values[~np.isfinite(values)][0]}")
    if a.size == 0:
        raise AssertionError(f"{what}: nothing to compare")
    allowed = atol + rtol * float(np.max(np.abs(e)))
    error = np.abs(a - e)
    if np.max(error) > allowed:
        worst = np.unravel_index(int(np.argmax(error)), error.shape)
        place = f" at {tuple(int(k) for k in worst)}" if a.ndim else ""
        raise AssertionError(
            f"{what}{place}: {a[worst]!r}, expected {e[worst]!r},"
            f" off by {error[worst]:.3g}, allowed {allowed:.3g}"
        )

"""Rates and accelerations at the rows of a motion that gives values only, or values and rates.

Between rows a player interpolates by quintics, whose accelerations are continuous in any case. The
missing derivatives are those of a cubic spline through values, and those that make the third
derivative continuous, too, where rates are given. Both begin and end at rest. A quintic spline
would be smoother, but swings far out where rows are spaced unevenly.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import make_interp_spline
from scipy.linalg import solve_banded

Array = NDArray[np.float64]


def completed(time: Array, given: Sequence[Array]) -> list[Array]:
    """Values, rates and accelerations (rows, n); given: the first one, two or three of them."""
    if len(given) == 1:
        return _spline(time, given[0])
    if len(given) == 2:
        return [*given, _accelerations(time, *given)]
    return list(given)


def _spline(time: Array, values: Array) -> list[Array]:
    at_rest = [(1, np.zeros(values.shape[1]))]
    spline = make_interp_spline(time, values, k=3, bc_type=(at_rest, at_rest))
    accelerations = spline(time, 2)
    accelerations[[0, -1]] = 0.0
    return [values, spline(time, 1), accelerations]


def _accelerations(time: Array, values: Array, rates: Array) -> Array:
    """Accelerations (rows, n) for which the third derivative has no step at any row inside.

    Of the quintic between two rows, h apart, it is at the begin
    (60 dy - h (36 v0 + 24 v1) - h^2 (9 a0 - 3 a1)) / h^3, at the end
    (60 dy - h (24 v0 + 36 v1) - h^2 (3 a0 - 9 a1)) / h^3.
    """
    h = np.diff(time)[:, None]
    dy, v0, v1 = np.diff(values, axis=0), rates[:-1], rates[1:]
    begin, end = 60 * dy - h * (36 * v0 + 24 * v1), 60 * dy - h * (24 * v0 + 36 * v1)
    right = np.zeros_like(values)
    right[1:-1] = (begin[1:] / h[1:] ** 3) - (end[:-1] / h[:-1] ** 3)
    bands = np.zeros((3, len(time)))
    bands[1] = 1.0
    per = 1 / h[:, 0]
    bands[0, 2:], bands[2, :-2] = -3 * per[1:], -3 * per[:-1]
    bands[1, 1:-1] = 9 * (per[1:] + per[:-1])
    return np.asarray(solve_banded((1, 1), bands, right))

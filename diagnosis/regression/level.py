"""How far off the values of a machine file are, as a multiple of their tolerances.

The tolerances of a file say how well its author believes to know the parameters. A robot's file is
often off by many: its bodies were drawn, not weighed. One common factor of all tolerances, of which
the evidence is largest (MacKay 1992, "Bayesian interpolation"), says what the runs find of it:

    s^2 = sum of squares of q_k / tolerance_k  /  number of parameters that the runs determine
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.regression.regression import Regression

Array = NDArray[np.float64]
FITS = 4
"""Fits until the factor is found."""


def freely(regression: Regression, count: int) -> tuple[Regression, float]:
    """A regression that allows for it that the first `count` parameters are off, and the factor's
    square, 1 or more."""
    known, freer, square = regression.prior[:count] / regression.doubt[:count], regression, 1.0
    for _ in range(FITS):
        before, square = square, off(freer, known)
        if square == before:
            break
        freer = regression.loosened({k: v / square for k, v in enumerate(known.tolist()) if v > 0})
    return freer, square


def off(regression: Regression, known: Array) -> float:
    """Mean square by which parameters of a fit are off, 1 or more; known (count,): what the machine
    file says of those at the beginning, inverse variances, zero for free ones."""
    own = np.flatnonzero(known > 0)
    held = regression.prior[own] * np.diag(regression.covariance)[own]
    determined = float((1.0 - np.clip(held, 0.0, 1.0)).sum())
    strain = float((known[own] * regression.q[own] ** 2).sum())
    return max(strain / max(determined, 1.0), 1.0)

"""Columns beside a base model, and their gains."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class GainEstimate:
    """Gains beta (k,) of columns with their covariance, robust to errors that go together within a
    cluster. lost (k,): columns that do not repeat, or that the base takes up: the rows say nothing
    of their gains, and their covariance is none. own (k, k): products of the columns without what
    the base takes up.
    """

    beta: Array
    covariance: Array
    lost: NDArray[np.bool_]
    own: Array


@dataclass(frozen=True)
class Beside:
    """Columns beside a base model. twin: of the other pass; c (k,): with what is left; moved
    (nb, k): what they move base coefficients by; gram (k, k): without what the base takes up; lost
    (k,): those that do not repeat, or that it takes up."""

    twin: Array
    c: Array
    moved: Array
    gram: Array
    lost: NDArray[np.bool_]

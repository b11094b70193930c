"""Derivatives of analytic functions without step-size trouble.

Everything the oracles compute is analytic in its arguments (no conjugate, no absolute
value), so derivatives come from values on a circle in the complex plane (Cauchy's integral
formula, exact to rounding), not from derivatives worked out by hand.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]


def taylor(
    f: Callable[[Array], Array], order: int, radius: float = 0.05, points: int = 16
) -> list[Array]:
    """Taylor coefficients c[0..order] of f about 0: f(s) = c[0] + c[1] s + c[2] s^2 ...

    f takes s (points,) complex and returns (points, ...) values. The error is the
    coefficient number `points` times radius^points, and rounding / radius^k for c[k].
    """
    angles = 2j * np.pi * np.arange(points) / points
    values = f(radius * np.exp(angles))
    return [
        np.einsum("j,j...->...", np.exp(-k * angles), values) / points / radius**k
        for k in range(order + 1)
    ]


def gradient(f: Callable[[Array], Array], x: Array, radius: float = 0.05) -> Array:
    """Derivative of f along each coordinate of a real x (n,): shape (n, ...), real.

    f takes (points, n) complex and returns (points, ...).
    """
    directions = np.eye(len(x))
    rows = [taylor(lambda s, e=e: f(x + s[:, None] * e), 1, radius)[1].real for e in directions]  # type: ignore[misc]
    return np.array(rows)

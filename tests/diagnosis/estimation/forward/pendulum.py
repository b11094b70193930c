"""Two links in a vertical plane with dry friction, by closed-form equations and SciPy."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

Array = NDArray[np.float64]
Rubs = Callable[[float], float]
L1, G = 0.4, 9.81
P = {"link_1.mc": 0.54, "link_1.J": 0.147, "link_2.m": 2.0, "link_2.mc": 0.30, "link_2.J": 0.075}
"""Of `init`'s example: first moments [kg m], moments of inertia about the joints [kg m2]."""


def drive(t: float | Array) -> Array:
    """Torques (..., 2) [N m] that carry the weight and swing the arm to and fro."""
    first, second = 10.0 * np.cos(5 * t) + 9.0, 2.5 * np.sin(9 * t) + 2.0
    return np.stack([first, second], axis=-1)


def acceleration(q: Array, v: Array, tau: Array) -> Array:
    """(2,) [rad/s2] of torques (2,) [N m] without friction."""
    m, mc, J1, mc1, J2 = (
        P[k] for k in ("link_2.m", "link_2.mc", "link_1.J", "link_1.mc", "link_2.J")
    )
    near, across = L1 * mc * np.cos(q[1]), L1 * mc * np.sin(q[1])
    a, b, c = J1 + m * L1**2 + J2 + 2 * near, J2 + near, J2
    weight = mc * G * np.cos(q[0] + q[1])
    x = tau[0] + across * (2 * v[0] + v[1]) * v[1] - (mc1 + m * L1) * G * np.cos(q[0]) - weight
    y = tau[1] - across * v[0] ** 2 - weight
    return np.array([c * x - b * y, a * y - b * x]) / (a * c - b * b)


def integrated(q: Array, v: Array, at: Array, rubs: tuple[Rubs, Rubs], start: float = 0.0) -> Array:
    """Angles (len(at), 2) after the times `at` [s] since `start`, from q, v (2,)."""

    def slope(t: float, x: Array) -> Array:
        friction = np.array([rub(rate) for rub, rate in zip(rubs, x[2:], strict=True)])
        return np.concatenate([x[2:], acceleration(x[:2], x[2:], drive(start + t) - friction)])

    first = np.concatenate([q, v])
    solved = solve_ivp(slope, (0, at[-1]), first, "Radau", at, rtol=1e-9, atol=1e-11)
    return np.asarray(solved.y[:2].T)

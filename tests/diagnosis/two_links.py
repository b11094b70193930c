"""A planar arm of two links with a point mass on it, by its textbook equations. NumPy alone."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
TS, SECONDS, NOISE = 2e-3, 12.0, 0.02
L1, G = 0.4, 9.81
BODIES = ((3.0, 0.18, 0.05), (2.0, 0.15, 0.03))
"""Mass [kg], centre of mass along the link [m], inertia about it [kg m2]."""


def moved(t: Array, seed: int) -> tuple[Array, Array, Array]:
    """theta, thetad, thetadd (samples, 2)."""
    rng = np.random.default_rng(seed)
    w, phase = rng.uniform(1.0, 9.0, (6, 2)), rng.uniform(0, 2 * np.pi, (6, 2))
    size = 0.6 / w
    x = w * t[:, None, None] + phase
    waves = np.sin(x), w * np.cos(x), -(w**2) * np.sin(x)
    theta, rate, acceleration = ((size * wave).sum(axis=1) for wave in waves)
    return theta, rate, acceleration


def torque(motion: tuple[Array, Array, Array], load: float, place: tuple[float, float]) -> Array:
    """Torques (samples, 2) [N m] with `load` [kg] at (x, y) [m] of the second link.

    Each body on the second link: mass m, inertia I, centre at the distance c and the angle phi.
    """
    (q1, q2), (v1, v2), (a1, a2) = (v.T for v in motion)
    m, c, inertia = BODIES[0]
    tau1 = (inertia + m * c**2) * a1 + m * c * G * np.cos(q1)
    tau2 = np.zeros_like(tau1)
    far, phi = float(np.hypot(*place)), float(np.arctan2(place[1], place[0]))
    for m, c, inertia, turn in ((*BODIES[1], 0.0), (load, far, 0.0, phi)):
        near, across = m * L1 * c * np.cos(q2 + turn), m * L1 * c * np.sin(q2 + turn)
        own, weight = inertia + m * c**2, m * c * G * np.cos(q1 + q2 + turn)
        tau1 += (own + m * L1**2 + 2 * near) * a1 + (own + near) * a2
        tau1 += -across * (2 * v1 * v2 + v2**2) + m * L1 * G * np.cos(q1) + weight
        tau2 += (own + near) * a1 + own * a2 + across * v1**2 + weight
    return np.stack([tau1, tau2], axis=1)


def run(seed: int, number: int, load: float, place: tuple[float, float]) -> dict[str, Array]:
    """time, theta, tau_meas of one pass of the motion `seed`."""
    t = np.arange(round(SECONDS / TS)) * TS
    motion, rng = moved(t, seed), np.random.default_rng([seed, number])
    theta = motion[0] + 2e-6 * rng.standard_normal((len(t), 2))
    tau = torque(motion, load, place) + NOISE * rng.standard_normal((len(t), 2))
    return {"time": t, "theta": theta, "tau_meas": tau}

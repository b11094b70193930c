"""Actuator and measurement filter in plain NumPy: chi, Dahl state, Hann window, stencils."""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp

from tests.oracles.calculus import Array
from tests.oracles.machine import Actuator


def chi(actuator: Actuator, theta: Array, thetad: Array, z: Array) -> Array:
    """Actuator torque (6,) [N m].  [SH, Eq. (22)]"""
    total = actuator.o + actuator.k * theta + actuator.d * thetad + actuator.c * z
    for n in range(1, actuator.a.shape[1] + 1):
        phase = n * actuator.omega * theta
        total = total + actuator.a[:, n - 1] * np.cos(phase) + actuator.b[:, n - 1] * np.sin(phase)
    return np.asarray(total)


def basis(omega: float, n_harmonics: int, theta: Array, z: Array) -> Array:
    """chi_f's columns before filtering (..., 6 (1 + 2 n)): per joint z, cos 1, sin 1, cos 2 ..."""
    columns = [z]
    for n in range(1, n_harmonics + 1):
        columns += [np.cos(n * omega * theta), np.sin(n * omega * theta)]
    return np.stack(columns, axis=-1).reshape(*theta.shape[:-1], -1)


def dahl(z: Array, step: Array, sigma: float) -> Array:
    """State after a monotone step of the angle [rad]: exact solution of [SH, Eq. (23)].

    Departs from [SH, Eq. (30)], an Euler step that diverges for |step| > 2 sigma.
    """
    s = np.sign(step)
    return np.where(step == 0, z, s + (z - s) * np.exp(-np.abs(step) / sigma))


def dahl_by_integration(z: float, step: float, sigma: float) -> float:
    """The same by numerical integration of dz/dtheta = (1 - sign z) / sigma, as a check."""
    s = np.sign(step)
    solution = solve_ivp(
        lambda _, y: s * (1 - s * y) / sigma, (0, abs(step)), [z], rtol=1e-12, atol=1e-14
    )
    return float(solution.y[0, -1])


def hann(points: int) -> Array:
    """Taps sin^2(pi n / points) divided by their sum, so that the DC gain is 1.

    [SH, Eq. (27)] prints no division; its 101 taps sum to 50.5.
    """
    taps = np.sin(np.pi * np.arange(points) / points) ** 2
    return np.asarray(taps / np.sum(taps))


def filtered(signal: Array, taps: Array) -> Array:
    """Causal FIR: row n is sum_k taps[k] signal[n - k]; rows begin where the window is full."""
    n = len(taps)
    rows = [taps[::-1] @ signal[k : k + n] for k in range(len(signal) - n + 1)]
    return np.array(rows)


def derivatives(signal: Array, Ts: float) -> tuple[Array, Array, Array]:
    """Value, first and second derivative at the middle of three samples: one sample late.

    Stencils [-1, 0, 1] / (2 Ts) and [1, -2, 1] / Ts^2; the print has the sign of the
    second turned. Each result is two rows shorter than the signal.
    """
    past, now, next_ = signal[:-2], signal[1:-1], signal[2:]
    return now, (next_ - past) / (2 * Ts), (next_ - 2 * now + past) / Ts**2

"""Seeded references with exact derivatives, and the error that a controller leaves in them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tests.oracles.calculus import Array

RATE = 2000.0
"""Samples a second of everything that is logged [Hz]."""
WARM = 1.0
"""Time before the first logged sample [s], in which hysteresis forgets its start."""
AMPLITUDE = 0.19
"""Setpoints lie within this [rad], as in machines/tflex.toml."""

Motion = tuple[Array, Array, Array]
"""Angles [rad], rates and accelerations, each (6, samples)."""


def instants(seconds: float) -> Array:
    """Times (samples,) [s]; the log starts at 0, the motion WARM earlier."""
    return np.arange(round((seconds + WARM) * RATE)) / RATE - WARM


def setpoints(t: Array, rng: np.random.Generator) -> Motion:
    """A setpoint a second, 0.6 s move with piecewise linear acceleration.  [SH, V-A]"""
    since = t - t[0]
    number = since.astype(int)
    points = rng.uniform(-AMPLITUDE, AMPLITUDE, (6, int(since[-1]) + 2))
    points[:, 0] = 0
    start, jump = points[:, number], np.diff(points, axis=1)[:, number]
    s, sd, sdd = _step(np.clip((since - number) / 0.6, 0, 1))
    return start + jump * s, jump * sd / 0.6, jump * sdd / 0.36


def _step(u: Array) -> Motion:
    """From 0 to 1 in unit time: acceleration in four straight lines, peak 8."""
    late = u > 0.5
    w = np.where(late, 1 - u, u)
    rise = w < 0.25
    left = 0.5 - w
    x = np.where(rise, 16 / 3 * w**3, 0.5 - 2 * left + 16 / 3 * left**3)
    v = np.where(rise, 16 * w**2, 2 - 16 * left**2)
    a = np.where(rise, 32 * w, 32 * left)
    return np.where(late, 1 - x, x), v, np.where(late, -a, a)


def multisine(t: Array, rng: np.random.Generator) -> Motion:
    """Eight sines a joint, 0.1 to 3.5 Hz, each joint its own."""
    w = 2 * np.pi * rng.uniform(0.1, 3.5, (6, 8))
    size = rng.uniform(0.3, 1.0, (6, 8)) / (1 + (w / 8) ** 2)
    phase = w[..., None] * t + rng.uniform(0, 2 * np.pi, (6, 8, 1))
    parts = size[..., None] * np.exp(1j * phase)
    q, v, a = (np.sum(parts * (1j * w[..., None]) ** k, axis=1).imag for k in range(3))
    scale = rng.uniform(0.7, 0.95) * AMPLITUDE / np.max(np.abs(q), axis=1, keepdims=True)
    return q * scale, v * scale, a * scale


def chirp(t: Array, rng: np.random.Generator) -> Motion:
    """0.15 to about 5 Hz, smaller as it gets faster; joints out of phase."""
    low, high = 0.15, rng.uniform(4.0, 5.5)
    slope = (high - low) / (t[-1] - t[0])
    f = low + slope * (t - t[0])
    phase = 2 * np.pi * (low * (t - t[0]) + slope * (t - t[0]) ** 2 / 2)
    turn = phase + rng.uniform(0, 2 * np.pi, (6, 1))
    pd, pdd = 2 * np.pi * f, 2 * np.pi * slope
    d = 1 + (f / 2) ** 2
    dd, ddd = f / 2 * slope, slope**2 / 2
    size = 0.75 * AMPLITUDE * rng.uniform(0.7, 1.0, (6, 1))
    A, Ad = size / d, -size * dd / d**2
    Add = size * (2 * dd**2 / d**3 - ddd / d**2)
    s, c = np.sin(turn), np.cos(turn)
    v = Ad * s + A * c * pd
    return A * s, v, (Add - A * pd**2) * s + (2 * Ad * pd + A * pdd) * c


def triangle(t: Array, rng: np.random.Generator) -> Motion:
    """Slow to and fro at nearly constant rate, corners rounded; joints out of phase."""
    w = 2 * np.pi * rng.uniform(0.08, 0.35, (6, 1))
    size, k = AMPLITUDE * rng.uniform(0.6, 0.95, (6, 1)), 0.995
    phase = w * t + rng.uniform(0, 2 * np.pi, (6, 1))
    S, Sd, Sdd = k * np.sin(phase), k * w * np.cos(phase), -k * w**2 * np.sin(phase)
    root = np.sqrt(1 - S * S)
    scale = size / np.arcsin(k)
    return scale * np.arcsin(S), scale * Sd / root, scale * (Sdd / root + S * Sd**2 / root**3)


KINDS: dict[str, Callable[[Array, np.random.Generator], Motion]] = {
    "setpoints": setpoints,
    "multisine": multisine,
    "chirp": chirp,
    "triangle": triangle,
}


@dataclass(frozen=True)
class Controller:
    """PID with its crossover at 10 Hz and 45 deg of phase, around an inertia J [kg m2]."""

    J: float = 0.075
    crossover: float = 10.0

    @property
    def gains(self) -> tuple[float, float, float]:
        """k_p [N m/rad], k_i [N m/(rad s)], k_d [N m s/rad]."""
        w = 2 * np.pi * self.crossover
        k_p = self.J * w * w / np.hypot(1, 1.2)
        return k_p, k_p * w / 10, 1.2 * k_p / w

    def error(self, d: Array) -> Motion:
        """Angle, rate, acceleration (6, samples) that a disturbance torque d [N m] leaves.

        s / (J s^3 + k_d s^2 + k_p s + k_i), in the frequency domain over a padded window.
        """
        samples = d.shape[1]
        pad = round(2 * RATE)
        fade = np.sin(np.linspace(0, np.pi / 2, round(0.4 * RATE))) ** 2
        wide = np.pad(d, ((0, 0), (0, pad)), mode="edge")
        wide[:, : len(fade)] *= fade
        wide[:, -pad:] *= np.cos(np.linspace(0, np.pi / 2, pad)) ** 2
        s = 2j * np.pi * np.fft.rfftfreq(wide.shape[1], 1 / RATE)
        k_p, k_i, k_d = self.gains
        H = s / (self.J * s**3 + k_d * s**2 + k_p * s + k_i)
        e = np.fft.rfft(wide) * H
        q, v, a = (np.fft.irfft(e * s**k, wide.shape[1])[:, :samples] for k in range(3))
        return q, v, a

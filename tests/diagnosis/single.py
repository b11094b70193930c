"""A single axis as nature has it: inertia, gravity, spring, LuGre friction, noise. NumPy, SciPy.

Nothing of the house is used but the channel names of a log.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

Array = NDArray[np.float64]
TS, SECONDS = 1e-3, 12.0
J, DAMPING, WEIGHT, SPRING = 0.08, 0.3, 1.4, 0.6
BRISTLE, STATIC, STRIBECK = 2e3, 1.2, 0.05
"""LuGre: bristle stiffness [1/rad relative to the friction], static over kinetic, rate [rad/s]."""


def moved(t: Array, seed: int) -> tuple[Array, Array, Array]:
    """theta, thetad, thetadd (samples,) of a smooth motion with many reversals."""
    rng = np.random.default_rng(seed)
    w, phase = rng.uniform(1.5, 14.0, 5), rng.uniform(0, 2 * np.pi, 5)
    size = 0.5 / w
    x = w * t[:, None] + phase
    waves = np.sin(x), w * np.cos(x), -(w**2) * np.sin(x)
    theta, rate, acceleration = (wave @ size for wave in waves)
    return theta, rate, acceleration


def wanted(t: Array, seed: int) -> Array:
    """Torque (samples,) [N m] that a motion takes without friction."""
    theta, rate, acceleration = moved(t, seed)
    return J * acceleration + DAMPING * rate + WEIGHT * np.sin(theta) + SPRING * theta + 0.05


def lugre(t: Array, rate: Array, friction: float) -> Array:
    """Friction torque (samples,) [N m] of bristles that bend and slip.

    dz/dt = v - beta |v| / s(v) z, exact for the mean rate of each sample; the torque is
    friction beta z, which tends to friction s(v) sign(v).
    """
    v = np.append(0.0, (rate[1:] + rate[:-1]) / 2)
    level = 1.0 + (STATIC - 1.0) * np.exp(-((v / STRIBECK) ** 2))
    decay = np.exp(-BRISTLE * np.abs(v) / level * np.gradient(t))
    bent = np.zeros_like(t)
    for k in range(1, len(t)):
        end = np.sign(v[k]) * level[k]
        bent[k] = end + (bent[k - 1] - end) * decay[k]
    return friction * bent


def wandering(count: int, corner: float, rng: np.random.Generator) -> Array:
    """Noise (count,) of unit RMS below a corner [Hz]."""
    kept = np.exp(-2 * np.pi * corner * TS)
    pushed = np.sqrt(1 - kept**2) * rng.standard_normal(count)
    return np.asarray(lfilter([1.0], [1.0, -kept], pushed))


def write(
    path: Path,
    seed: int,
    number: int,
    friction: float,
    noise: float = 0.01,
    extra: Array | float = 0.0,
    run: int = 0,
    scale: float = 1.0,
    steps: float = 1e-6,
    seconds: float = SECONDS,
    zero: float = 0.0,
) -> Path:
    """One pass of the motion `seed`, with noise of its own; friction [N m], noise [N m].

    extra: any other torque [N m]; run: its place in the order of all runs, 0 for none; scale: by
    which all torques are larger; steps [rad] of the encoder, whose noise is twice that; zero [rad]:
    that it is off by.
    """
    t = np.arange(round(seconds / TS)) * TS
    theta, rate, _ = moved(t, seed)
    tau = wanted(t, seed)
    if friction:
        tau = tau + lugre(t, rate, friction)
    rng = np.random.default_rng([seed, number])
    seen = np.round((theta + 2 * steps * rng.standard_normal(len(t)) + zero) / steps) * steps
    tau = scale * (tau + noise * rng.standard_normal(len(t)) + extra)
    place = [f"# run: {run}"] if run else []
    head = [
        f"# trajectory: {seed}",
        f"# pass: {number}",
        *place,
        "time,theta[1],tau_meas[1]",
        "s,rad,N m",
    ]
    rows = [f"{a:.6f},{b:.7f},{c:.7g}" for a, b, c in zip(t, seen, tau, strict=True)]
    path.write_text("\n".join([*head, *rows, ""]))
    return path


def thinned(path: Path, step: int) -> Path:
    """The same log with one of so many samples."""
    lines = path.read_text().splitlines(keepends=True)
    head = next(k for k, line in enumerate(lines) if line[0] in "-.0123456789")
    path.write_text("".join([*lines[:head], *lines[head::step]]))
    return path

"""Axes driven by the voltage of DC motors as nature has them: electrical pole, back-EMF, gear,
inertia, Coulomb and viscous friction, cogging, noise. NumPy and SciPy.

Nothing of the house is used but the channel names of a log.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

Array = NDArray[np.float64]
TS, SECONDS = 1e-3, 12.0
R, K, L, GEAR = 1.2, 0.05, 3.6e-3, 20.0
"""Of the motor: ohm, N m/A and V s/rad, H (a pole of 3 ms); its turns per turn of the axis."""
J, D, F_C, COGGING, ORDER = 0.08, 0.3, 0.25, 0.15, 24.0
"""Of the axis: kg m2, N m s/rad, N m, N m, periods a turn."""
SMOOTH = 2e-3
"""Rate [rad/s] within which Coulomb friction turns over: no solver stands a jump."""
GAINS = 60.0, 2.0
"""Of the controller, V/rad and V s/rad at the axis."""
STEP, NOISE = 1e-5, 0.02
"""Of the encoder [rad], and standard deviation of the logged voltage [V]."""
RUNS = ((1, 1), (1, 2), (2, 1), (2, 2), (3, 1))
"""Motion and pass; the last one is held out."""


@cache
def driven(seed: int, rubbed: float, inertia: float = J) -> tuple[Array, Array]:
    """Angle [rad] and voltage of the motor [V] (samples,) as it follows the motion `seed`; rubbed:
    Coulomb friction and cogging in those above; inertia of the axis [kg m2]."""
    rng = np.random.default_rng(seed)
    w, phase = rng.uniform(1.5, 14.0, 5), rng.uniform(0, 2 * np.pi, 5)
    size = 0.5 / w

    def voltage(t: float, theta: float, rate: float) -> float:
        r, rd = size @ np.sin(w * t + phase), (size * w) @ np.cos(w * t + phase)
        return float(GAINS[0] * (r - theta) + GAINS[1] * (rd - rate) + K * GEAR * rd)

    def moves(t: float, state: Array) -> list[float]:
        theta, rate, current = state
        left = GEAR * K * current - D * rate - rubbed * F_C * np.tanh(rate / SMOOTH)
        left -= rubbed * COGGING * np.cos(ORDER * theta)
        pushed = voltage(t, theta, rate) - R * current - K * GEAR * rate
        return [rate, left / inertia, pushed / L]

    t = np.arange(round(SECONDS / TS)) * TS
    begin = [float(size @ np.sin(phase)), float((size * w) @ np.cos(phase)), 0.0]
    solved = solve_ivp(moves, (0.0, SECONDS), begin, "LSODA", t, rtol=1e-7, atol=1e-9)
    theta, rate = solved.y[:2]
    return theta, np.array([voltage(*row) for row in zip(t, theta, rate, strict=True)])


def write(
    folder: Path,
    head: Sequence[str] = (),
    rubbed: float = 1.0,
    channel: tuple[str, str] = ("tau_meas", "V"),
    divided: float = 1.0,
    way: tuple[float, str] = (1.0, "rad"),
    heavy: float = 0.0,
) -> list[Path]:
    """Logs of RUNS. head: more lines of it, without `# `; channel: name and unit of the voltage,
    divided: by which its numbers are smaller; way: of the axis per angle, and its unit; heavy: more
    inertia in each second pass [kg m2]."""
    folder.mkdir(exist_ok=True)
    t, paths = np.arange(round(SECONDS / TS)) * TS, list[Path]()
    for seed, number in RUNS:
        theta, voltage = driven(seed, rubbed, J + heavy * (number == 2))
        rng = np.random.default_rng([seed, number])
        read = np.round((theta + STEP * rng.standard_normal(len(t))) / STEP) * STEP
        seen = (voltage + NOISE * rng.standard_normal(len(t))) / divided
        name, unit = channel
        lines = [f"# {line}" for line in (f"trajectory: {seed}", f"pass: {number}", *head)]
        lines += [f"time,theta[1],{name}[1]", f"s,{way[1]},{unit}"]
        lines += [
            f"{a:.6f},{b:.9g},{c:.7g}" for a, b, c in zip(t, way[0] * read, seen, strict=True)
        ]
        paths.append(folder / f"{seed}-{number}.csv")
        paths[-1].write_text("\n".join([*lines, ""]))
    return paths

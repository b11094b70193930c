"""Sample logs of one axis, as a drive might record them.

    python examples/axis/make_logs.py [FOLDER]

The axis has inertia, damping, gravity and a spring, and Coulomb friction that `--base axis` does
not know. Two motions are run twice each, a third one once, to be held out. The torque has noise,
the encoder 2^20 steps in a turn. `drive-a1.csv` ... are the same runs as a drive's tool saves them:
angles in degrees, currents, semicolons, no units.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

TS, SECONDS = 2e-3, 8.0
J, DAMPING, SPRING, WEIGHT, OFFSET = 0.05, 0.08, 0.15, 0.9, -0.1
"""[kg m2], [N m s/rad], [N m/rad], [N m], [N m]."""
FRICTION, TURN = 0.1, 0.005
"""Coulomb friction [N m]; rate at which it turns over [rad/s]."""
NOISE, STEP = 0.01, 2 * np.pi / 2**20
"""Noise of the torque [N m], step of the encoder [rad]."""
TORQUE_CONSTANT = 0.8
"""Of the drive's files [N m/A]."""
RUNS = {"a1": ("a", 1), "a2": ("a", 2), "b1": ("b", 1), "b2": ("b", 2), "c1": ("c", 1)}
"""File -> motion, pass."""


def motion(t: np.ndarray, name: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Angle [rad], rate and acceleration: five sines that the motion's name draws."""
    draw = np.random.default_rng(ord(name))
    w, phase = draw.uniform(1.5, 12.0, 5), draw.uniform(0, 2 * np.pi, 5)
    x, size = w * t[:, None] + phase, 0.5 / w
    waves = np.sin(x), w * np.cos(x), -(w**2) * np.sin(x)
    return tuple(wave @ size for wave in waves)


def log(name: str, number: int) -> str:
    """One run as CSV: names, units, samples."""
    t = TS * np.arange(round(SECONDS / TS))
    theta, rate, acceleration = motion(t, name)
    tau = J * acceleration + DAMPING * rate + SPRING * theta + WEIGHT * np.sin(theta) + OFFSET
    tau += FRICTION * np.tanh(rate / TURN)
    tau += NOISE * np.random.default_rng([ord(name), number]).standard_normal(len(t))
    lines = [f"# trajectory: {name}", f"# pass: {number}", "time,theta,tau_meas", "s,rad,N m"]
    rows = zip(t, STEP * np.round(theta / STEP), tau, strict=True)
    lines += [f"{a:.3f},{b:.7f},{c:.4f}" for a, b, c in rows]
    return "\n".join(lines) + "\n"


def of_drive(text: str) -> str:
    """The same run in degrees and amperes, with one line of names."""
    lines = ["Time;Position;Current"]
    for row in text.splitlines()[4:]:
        t, theta, tau = map(float, row.split(","))
        lines.append(f"{t:.3f};{np.degrees(theta):.6f};{tau / TORQUE_CONSTANT:.5f}")
    return "\n".join(lines) + "\n"


def main() -> None:
    """Write all runs beside this file, or into the folder that is given."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent
    for file, (name, number) in RUNS.items():
        text = log(name, number)
        (folder / f"{file}.csv").write_text(text, encoding="utf-8")
        if name != "c":
            (folder / f"drive-{file}.csv").write_text(of_drive(text), encoding="utf-8")


if __name__ == "__main__":
    main()

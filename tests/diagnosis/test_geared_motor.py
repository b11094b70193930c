"""A motor logged before its gear: what repeats with the output makes one wave in many turns."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexhex.diagnosis.workflow import Options, diagnose

TS, SECONDS, GEAR = 2e-3, 20.0, 25.0
J, DAMPING, ECCENTRIC = 2e-4, 1e-3, 0.03
"""kg m2, N m s/rad, N m."""


def _write(path: Path, seed: int, number: int) -> Path:
    """A pass of a motion of some fifty turns; the output's wheel runs out of true."""
    t = np.arange(round(SECONDS / TS)) * TS
    rng = np.random.default_rng(seed)
    w, phase = rng.uniform(0.6, 2.5, 4), rng.uniform(0, 2 * np.pi, 4)
    x = w * t[:, None] + phase
    size = 60.0 / w
    theta, rate, more = np.sin(x) @ size, np.cos(x) @ (w * size), -np.sin(x) @ (w**2 * size)
    tau = J * more + DAMPING * rate + ECCENTRIC * np.sin(theta / GEAR + 0.3)
    noise = np.random.default_rng([seed, number])
    seen = theta + 1e-3 * noise.standard_normal(len(t))
    tau = tau + 1e-3 * noise.standard_normal(len(t))
    head = f"# trajectory: {seed}\n# pass: {number}\ntime,theta[1],tau_meas[1]\ns,rad,N m"
    rows = np.column_stack([t, seen, tau])
    np.savetxt(path, rows, "%.9g", ",", header=head, comments="")
    return path


def test_wheel_behind_a_gear_is_a_wave_of_many_turns(tmp_path: Path) -> None:
    paths = [_write(tmp_path / f"{s}_{k}.csv", s, k) for s in (1, 2) for k in (1, 2)]
    diagnosis = diagnose(paths, [_write(tmp_path / "t.csv", 3, 1)], options=Options(base="axis"))
    (effect,) = diagnosis.effects
    assert effect.id == "cogging_harmonic"
    order = effect.parameters["order"]
    assert order.value == pytest.approx(1 / GEAR, rel=0.02)
    assert order.ci95[0] < 1 / GEAR < order.ci95[1]

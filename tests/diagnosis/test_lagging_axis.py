"""A drive that lags behind its command on a single axis is no log that is late, nor the other way
round."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.estimation.extras import Extra, Extras
from flexhex.diagnosis.estimation.identified import identify
from flexhex.diagnosis.hypotheses.signals import let_through
from flexhex.diagnosis.result.verdict import Diagnosis
from flexhex.diagnosis.workflow import Options, diagnose
from flexhex.fmus.common.effects import library
from tests.diagnosis.synthetic import plain_csv

Array = NDArray[np.float64]
TS, LAG, LATE = 1e-3, 4e-3, 3e-3
INERTIA, VISCOUS, COULOMB, WITHIN, NOISE = 0.4, 0.8, 1.2, 0.02, 0.02
CHIRPS = ((0.05, 0.5, 16.0, 1.0), (0.03, 1.0, 22.0, -1.5), (0.04, 14.0, 0.7, 0.6))
"""Of a motion: amplitude at 1 Hz [rad], first and last frequency [Hz], and of a slow wave beside
the chirp [rad/s]."""


def joint(
    t: Array, amplitude: float, first: float, last: float, slow: float
) -> tuple[Array, Array]:
    """Angle and torque of an axis along a chirp of one speed beside a slow wave."""
    sweep = (last - first) / 8.0
    phase = 2 * np.pi * (first * t + 0.5 * sweep * t**2)
    pace, slope = 2 * np.pi * (first + sweep * t), 2 * np.pi * sweep
    size = amplitude * 2 * np.pi / pace
    shrink = -size * slope / pace
    wave, its_rate = 0.6 * np.sin(slow * t), 0.6 * slow * np.cos(slow * t)
    angle = size * np.sin(phase) + wave
    rate = size * pace * np.cos(phase) + shrink * np.sin(phase) + its_rate
    bend = 2 * size * (slope / pace) ** 2
    turn = bend - size * pace**2
    acceleration = shrink * pace * np.cos(phase) + turn * np.sin(phase) - slow**2 * wave
    return angle, INERTIA * acceleration + VISCOUS * rate + COULOMB * np.tanh(rate / WITHIN)


def logs(folder: Path, command: Callable[..., Array]) -> list[Path]:
    """Runs whose torque is the command to the drive: of the time and a chirp."""
    paths, t, rng = list[Path](), np.arange(0.0, 8.0, TS), np.random.default_rng(3)
    for motion, chirp in enumerate(CHIRPS):
        for number in (1, 2):
            tau = command(t, *chirp) + NOISE * rng.standard_normal(len(t))
            run = {"time": t, "theta": joint(t, *chirp)[0][:, None], "tau_meas": tau[:, None]}
            head = {"trajectory": str(motion), "pass": str(number)}
            paths.append(plain_csv(folder / f"{motion}{number}.csv", run, **head))
    return paths


def diagnosed(folder: Path, command: Callable[..., Array]) -> Diagnosis:
    """Of these."""
    return diagnose(logs(folder, command), options=Options(base="axis"))


def hurried(t: Array, *chirp: float) -> Array:
    """The torque of the joint and LAG times its rate."""
    step = 1e-5
    before, now, after = (joint(t + s, *chirp)[1] for s in (-step, 0.0, step))
    return np.asarray(now + LAG * (after - before) / (2 * step))


def early(t: Array, *chirp: float) -> Array:
    """The torque of the joint LATE before it is there."""
    return joint(t + LATE, *chirp)[1]


def test_lag_of_a_drive_is_named_and_bends_nothing(tmp_path: Path) -> None:
    found = diagnosed(tmp_path, hurried)
    effects = {effect.id: effect for effect in found.effects}
    assert (found.verdict, set(effects)) == ("named", {"drive_lag", "coulomb_friction"})
    assert effects["drive_lag"].parameters["T_lag"].value == pytest.approx(LAG, rel=0.01)
    assert effects["coulomb_friction"].parameters["F_c"].value == pytest.approx(COULOMB, rel=0.03)
    values = {one.name: one.estimate.value for one in found.parameters}
    assert values["J[1]"] == pytest.approx(INERTIA, rel=0.005)
    assert values["d[1]"] == pytest.approx(VISCOUS, rel=0.02)
    assert not any("delay" in text for text in found.findings)


def test_identification_beside_a_lag_simulates_the_axis(tmp_path: Path) -> None:
    """Without the lag it has a delay, which leaves more."""
    paths = logs(tmp_path, hurried)
    lag = Extra(library()["drive_lag"], 0, {}, gains=(0.95 * LAG,))
    runs = paths[:4], paths[4:], None, Options(base="axis")
    with_lag, without = (identify(*runs, more=Extras(own)) for own in ((lag,), ()))
    values = {one.name: one.estimate.value for one in with_lag.parameters}
    assert values["drive_lag.T_lag[1]"] == pytest.approx(LAG, rel=0.01)
    assert values["J[1]"] == pytest.approx(INERTIA, rel=0.005)
    assert abs(with_lag.delay.value) < 1e-6
    assert with_lag.simulation is not None
    assert without.simulation is not None
    assert not with_lag.simulation.left_out
    error, other = (one.at(one.fitted)[0, 0] for one in (with_lag.simulation, without.simulation))
    assert error < 0.5 * other


def test_late_log_is_no_lag(tmp_path: Path) -> None:
    found = diagnosed(tmp_path, early)
    assert [effect.id for effect in found.effects] == ["coulomb_friction"]
    assert any(f"leads the angles by {1e3 * LATE:.0f} ms" in text for text in found.findings)


def test_lag_is_exact_for_straight_lines() -> None:
    t = np.arange(0.0, 0.1, TS)
    steep, flat = 3.0 * t, np.full_like(t, 2.0)
    answer = let_through(np.stack([steep, flat], axis=1), "lag", LAG, TS)
    np.testing.assert_allclose(answer[:, 0], steep - 3.0 * LAG * (1 - np.exp(-t / LAG)), atol=1e-12)
    np.testing.assert_allclose(answer[:, 1], flat, rtol=1e-12)

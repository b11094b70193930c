"""A motion that is not quiet is smoothed as long as little is lost that repeats, and what differs
between passes swings nothing."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.axis import AxisBase
from flexhex.diagnosis.jointfit.smoothed import fitted
from flexhex.diagnosis.runs.differences import motion_of
from flexhex.diagnosis.runs.run import Run, TimeSeries
from flexhex.diagnosis.workflow import Options, diagnose

Array = NDArray[np.float64]
TS, COUNT = 1e-3, 14000
MOTOR, LOAD, RATIO = 0.02, 0.05, 0.04
"""Inertias of motor and load [kg m2], damping ratio of the spring between them."""


def noise(rng: np.random.Generator, size: float, most: float) -> Array:
    """Random values (COUNT,) of this RMS, below so many hertz."""
    spectrum = np.fft.rfft(rng.standard_normal(COUNT))
    spectrum[np.fft.rfftfreq(COUNT, TS) > most] = 0.0
    values = np.fft.irfft(spectrum, COUNT)
    return np.asarray(size * values / values.std())


def moved(motion: int, frequency: float) -> tuple[Array, Array]:
    """Angle of the motor (COUNT,) [rad] and its torque [N m], in the steady state of waves of whole
    periods, of which the fastest has 6 Hz: the load swings on a spring."""
    rng = np.random.default_rng(motion)
    hertz = np.fft.rfftfreq(COUNT, TS)
    angle = np.zeros(len(hertz), dtype=complex)
    for f in (*rng.uniform(0.2, 1.2, 4), *rng.uniform(2.0, 6.0, 2)):
        place = round(f * COUNT * TS)
        angle[place] = COUNT / 2 * 0.3 / hertz[place] * np.exp(1j * rng.uniform(0, 2 * np.pi))
    s, w = 2j * np.pi * hertz, 2 * np.pi * frequency
    follows = (w**2 + 2 * RATIO * w * s) / (s**2 + 2 * RATIO * w * s + w**2)
    torque = (MOTOR + LOAD * follows) * s**2 * angle
    return np.fft.irfft(angle, COUNT), np.fft.irfft(torque, COUNT)


def write(path: Path, motion: int, number: int, frequency: float, size: float) -> Path:
    """One pass. Disturbances of this RMS [rad] that the drive does not report move the motor."""
    theta, tau = moved(motion, frequency)
    rng = np.random.default_rng([motion, number])
    theta = theta + noise(rng, size, 30.0)
    tau = tau + 0.01 * rng.standard_normal(COUNT)
    rows = np.column_stack([TS * np.arange(COUNT), theta, tau])
    head = f"# trajectory: {motion}\n# pass: {number}\ntime,theta[1],tau_meas[1]\ns,rad,N m"
    np.savetxt(path, rows, "%.9g", ",", header=head, comments="")
    return path


@pytest.mark.parametrize(("frequency", "size"), [(9.0, 2e-4), (9.0, 2e-7), (20.0, 2e-4)])
def test_mode_beyond_the_motion_is_where_it_is(
    frequency: float, size: float, tmp_path: Path
) -> None:
    """Noise of the motion makes each mode swing at its own frequency, which hides what little
    tells them apart, and so would a start at rest: the logs begin in motion. One that is far beyond
    the motion shows as no more than an inertia that grows with the square of the frequency, and the
    interval says so."""
    runs = [(k, n) for k in (1, 2, 3) for n in (1, 2)]
    paths = [write(tmp_path / f"{k}_{n}.csv", k, n, frequency, size) for k, n in runs]
    found = diagnose(paths[:4], paths[4:], options=Options("axis"))
    assert [e.id for e in found.effects] == ["flexible_mode"]
    values = found.effects[0].parameters
    for name, truth in (("f", frequency), ("J_2", LOAD)):
        low, high = values[name].ci95
        assert low <= truth <= high
    if frequency < 15.0:
        assert values["f"].value == pytest.approx(frequency, rel=0.05)


def one(number: int, fast: float, trajectory: str = "a", size: float = 2e-4) -> Run:
    """A pass of a rigid motion with disturbances [rad] and a torque of 20 Hz [N m] that repeats."""
    theta, _ = moved(1, 1e4)
    rng = np.random.default_rng(number)
    valid = np.ones(COUNT, dtype=bool)
    quiet = motion_of(TimeSeries(0.0, TS, theta[:, None], valid), None)
    seen = (theta + noise(rng, size, 30.0))[:, None]
    torque = (MOTOR + LOAD) * quiet.thetadd[:, 0]
    torque += fast * np.sin(40 * np.pi * TS * np.arange(len(torque)))
    torque += 0.01 * rng.standard_normal(len(torque))
    tau = TimeSeries(quiet.t0, TS, torque[:, None], np.ones(len(torque), dtype=bool))
    motion = motion_of(TimeSeries(0.0, TS, seen, valid), None)
    return Run(str(number), trajectory, motion, tau.valid, tau)


def window(*runs: Run) -> float:
    """How much longer than the base's own the window is."""
    base = AxisBase(1, TS)
    return fitted(base, runs)[0].base.window / base.window


def test_window_is_as_long_as_the_torque_that_repeats_lets() -> None:
    assert window(one(1, 0.0), one(2, 0.0)) > 2.0
    assert window(one(1, 4.0), one(2, 4.0)) == 1.0


def test_torque_that_does_not_repeat_is_not_lost() -> None:
    assert window(one(1, 4.0), one(2, -4.0)) > 2.0


def test_quiet_motion_is_not_smoothed() -> None:
    assert window(one(1, 0.0, size=2e-7), one(2, 0.0, size=2e-7)) == 1.0


def test_nothing_that_was_run_once_is_smoothed_away() -> None:
    assert window(one(1, 0.0), replace(one(2, 0.0), trajectory="b")) == 1.0

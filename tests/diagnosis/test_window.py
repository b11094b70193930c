"""The window grows with the noise of the angles, and only where accelerations come from them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.axis import AxisBase
from flexhex.diagnosis.basemodels.base import Motion
from flexhex.diagnosis.jointfit.smoothed import fitted
from flexhex.diagnosis.regression.window import LONGER, LONGEST
from flexhex.diagnosis.runs.differences import motion_of
from flexhex.diagnosis.runs.run import Run, TimeSeries

Array = NDArray[np.float64]
TS, INERTIA = 1e-3, 0.08


def run(
    seed: int, noise: float, step: float = 0.0, seconds: float = 40.0, waver: float = 0.0
) -> Run:
    """A pass of a slow motion: inertia alone, and a wave that a longer window would take away;
    angles with noise or in steps."""
    t = TS * np.arange(round(seconds / TS))
    theta = 0.3 * np.sin(4 * t) + 0.1 * np.sin(11 * t + 1)
    torque = -INERTIA * (0.3 * 16 * np.sin(4 * t) + 0.1 * 121 * np.sin(11 * t + 1))
    torque += 3e-2 * np.sin(2 * np.pi * 40.0 * t)
    rng = np.random.default_rng(seed)
    seen = theta + noise * rng.standard_normal(len(t))
    seen += wavering(len(t), waver, rng)
    if step:
        seen = step * np.round(seen / step)
    valid = np.ones(len(t), dtype=bool)
    motion = motion_of(TimeSeries(0.0, TS, seen[:, None], valid), None)
    tau = torque + 1e-3 * rng.standard_normal(len(t))
    return Run(str(seed), "a", motion, valid[2:-2], TimeSeries(0.0, TS, tau[:, None], valid))


def smoothed(*runs: Run) -> tuple[float, Array, str]:
    """How much longer than the base's own the window is, what noise is left, what is said."""
    base = AxisBase(1, TS)
    model, left, text = fitted(base, runs)
    return model.base.window / base.window, left, text


def measured(run: Run) -> Run:
    """The same, as though the rate had been measured."""
    m = run.motion
    return replace(run, motion=Motion(m.t0, m.ts, m.theta, m.thetad, m.thetadd, noise=m.noise))


def test_quiet_angles_keep_the_window() -> None:
    assert smoothed(run(1, 1e-7), run(2, 1e-7))[0] == 1.0


def test_noise_of_angles_asks_for_a_longer_window() -> None:
    longer, left, text = smoothed(run(1, 6e-4), run(2, 6e-4))
    assert 1.5 < longer < LONGEST
    assert "angles of axis 1 are noisy" in text
    assert not left.any()


def test_steps_that_repeat_ask_for_more_than_noise_of_their_size() -> None:
    step = 1e-4
    in_steps, _, said = smoothed(run(1, 0.0, step), run(2, 0.0, step))
    assert in_steps > 2.0
    assert "come in steps of 0.0001 rad" in said
    as_noise = step / np.sqrt(12)
    longer, _, text = smoothed(run(1, as_noise), run(2, as_noise))
    assert longer < in_steps
    assert text == ""


def test_steps_beyond_help_are_left_and_said() -> None:
    longer, left, text = smoothed(run(1, 0.0, 1e-2), run(2, 0.0, 1e-2))
    assert longer > LONGEST / LONGER
    assert left[0] > 0
    assert "come in steps of 0.01 rad" in text


def test_measured_rates_need_no_longer_window() -> None:
    noisy = run(1, 6e-4), run(2, 6e-4)
    assert "angles of axis 1 are noisy" in smoothed(*noisy)[2]
    assert smoothed(*map(measured, noisy))[2] == ""


@pytest.mark.parametrize("size", [0.0, 3e-3])
def test_noise_that_looks_like_motion_does_not_make_an_inertia_small(size: float) -> None:
    """Angles that waver, as those whose times are wrong, of runs without repeats: most of their
    accelerations are noise, of which differences of neighbours tell nothing, and the inertia that
    fits these is too small."""
    runs = [replace(run(k, 1e-7, waver=size), trajectory=str(k)) for k in (1, 2)]
    base = AxisBase(1, TS)
    model, _, text = fitted(base, runs)
    place = [k.group for k in base.linear].index("J")
    assert model.fitted.p[place] == pytest.approx(INERTIA, rel=0.1)
    assert (model.base.window > base.window) == (size > 0)
    assert ("accelerations are noisy" in text) == (size > 0)


def wavering(count: int, size: float, rng: np.random.Generator) -> Array:
    """Errors (count,) [rad] of this RMS, below 25 Hz."""
    spectrum = np.fft.rfft(rng.standard_normal(count))
    spectrum[np.fft.rfftfreq(count, TS) > 25.0] = 0.0
    off = np.fft.irfft(spectrum, count)
    return np.asarray(size * off / off.std())


def test_short_runs_keep_rows_enough() -> None:
    step = 1e-2
    short, left, _ = smoothed(run(1, 0.0, step, 12.0), run(2, 0.0, step, 12.0))
    assert 1.0 < short < LONGEST
    assert left[0] > 0

"""The example of another arm: what is a period, and friction that is read off without a model."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from examples.ur10e.diagnose import main, passes, periods, reversals
from flexhex.diagnosis.logs import Options, read_log
from tests.diagnosis.synthetic import Array

JOINT, FRICTION = 4, 0.3


def log(seconds: float = 49.0, rest: float = 0.0) -> Array:
    """Samples (samples, 31) as the authors log them: lead-in, then a sine of 10 s, then rest;
    current of dry friction, damping and gravity. rest [s]: a stop at 18 s, in the second period."""
    rng = np.random.default_rng(1)
    time = 1000.0 + np.cumsum(np.where(rng.random(round(93 * seconds)) < 0.36, 0.012, 0.010))
    clock = time - time[0] - 2.0
    clock = np.where(clock < 16.0, clock, np.maximum(clock - rest, 16.0))
    phase = np.clip(clock, 0.0, 43.5) * 2 * np.pi / 10
    angle, rate = np.sin(phase) - 1.5, np.cos(phase) * ((phase > 0) & (phase < phase[-1]))
    samples = np.zeros((len(time), 31))
    current = FRICTION * np.sign(rate) + 0.05 * rate + 0.4 * np.cos(angle)
    samples[:, 0], samples[:, JOINT] = time, np.round(angle, 4)
    samples[:, 12 + JOINT] = current + 0.02 * rng.standard_normal(len(time))
    return samples


def test_whole_periods_alone_are_passes(tmp_path: Path) -> None:
    samples = log()
    ends = [samples[k, 0] - samples[0, 0] for pair in periods(samples, JOINT) for k in pair]
    assert ends == pytest.approx([4.5, 14.5, 14.5, 24.5, 24.5, 34.5, 34.5, 44.5], abs=0.1)
    runs = [
        read_log(path, Options(torque_constant=10.0)) for path in passes(samples, JOINT, tmp_path)
    ]
    assert [(run.trajectory, run.pass_number) for run in runs] == [("sine", k) for k in range(1, 5)]
    assert runs[0].theta[0, 0] == pytest.approx(-0.5, abs=2e-4)
    assert np.ptp(runs[0].theta) == pytest.approx(2.0, abs=1e-3)
    rest = np.abs(runs[0].tau[:, 0] / 10 - 0.4 * np.cos(runs[0].theta[:, 0]))
    # the damping adds 0.05 times a rate of 1 / sqrt(2) in the median
    assert np.median(rest) == pytest.approx(FRICTION + 0.035, rel=0.02)


def test_period_with_a_stop_in_it_is_no_pass() -> None:
    samples = log(52.0, rest=3.0)
    ends = [samples[k, 0] - samples[0, 0] for pair in periods(samples, JOINT) for k in pair]
    assert ends == pytest.approx([4.5, 14.5, 27.5, 37.5, 37.5, 47.5], abs=0.1)


def test_dry_friction_is_half_of_the_jump_at_the_reversals() -> None:
    # the damping adds 0.05 times the tenth of the largest rate; gravity is larger than either
    lower, upper = reversals(log(), JOINT)
    assert lower == pytest.approx((FRICTION + 0.005, -0.4 * np.cos(-2.5)), rel=0.03)
    assert upper == pytest.approx((FRICTION + 0.005, 0.4 * np.cos(-0.5)), rel=0.03)


def test_example_says_what_it_lacks(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([str(tmp_path)]) == 3
    said = capsys.readouterr().out
    assert "joint_1.csv: no such file; examples/ur10e/README.md tells where from" in said

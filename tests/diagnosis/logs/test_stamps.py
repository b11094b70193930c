"""Uneven times: those of a logger that samples when it can, and those of one that stamps late."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexhex.diagnosis.logs import read_log
from tests.diagnosis.logs.test_faults import TS, finding, with_time
from tests.diagnosis.synthetic import Array, plain_csv

RATE = 93.0
"""Of a controller that sends in steps of 2 ms, about every 10.75 ms."""


def uneven(seconds: float = 20.0, seed: int = 3) -> Array:
    """Times of the samples [s]: 10 and 12 ms apart, as it happens."""
    rng = np.random.default_rng(seed)
    steps = np.where(rng.random(round(seconds * RATE)) < 0.36, 0.012, 0.010)
    return np.concatenate([[0.0], np.cumsum(steps)])


def angle(t: Array) -> Array:
    """Angles (samples, 2) [rad]."""
    return np.column_stack([0.8 * np.sin(2 * t), 0.3 * np.cos(5 * t)])


def torque(t: Array) -> Array:
    """Torques (samples, 2) [N m] with a jump at every reversal."""
    return np.column_stack([9.0 * np.sign(np.cos(2 * t)), 4.0 * np.cos(5 * t)])


def run(t: Array, at: Array, seed: int = 4) -> dict[str, Array]:
    """A log with time t of samples that were taken at `at`, in steps of 0.1 mrad."""
    noise = 0.05 * np.random.default_rng(seed).standard_normal((len(t), 2))
    return {"time": t, "theta": np.round(angle(at), 4), "tau_meas": torque(at) + noise}


def test_times_at_which_the_motion_is_smooth_are_the_samples(tmp_path: Path) -> None:
    t = uneven()
    log = read_log(plain_csv(tmp_path / "a.csv", run(t, t)))
    text = finding(log, "jitter")
    assert text.corrected
    assert "and is right (even times would make the motion" in text.text
    theta = log["theta"]
    assert theta.valid.all()
    assert theta.ts == pytest.approx(np.diff(t).mean(), rel=0.01)
    assert theta.time[-1] == pytest.approx(t[-1], abs=theta.ts)
    # half a step of 0.1 mrad and what a cubic of it makes; even times would be 10 mrad off
    assert np.abs(theta.values - angle(theta.time)).max() < 1e-4


def test_times_that_the_motion_does_not_follow_are_stamps_that_came_late(tmp_path: Path) -> None:
    even = np.arange(2000) / RATE
    late = even + 1e-3 * np.random.default_rng(5).random(len(even))
    log = read_log(plain_csv(tmp_path / "a.csv", run(late, even)))
    assert "taken as even" in finding(log, "jitter").text
    assert np.array_equal(log.theta, np.round(angle(even), 4))


def test_what_was_not_recorded_and_what_is_no_number_is_not_used(tmp_path: Path) -> None:
    t = uneven()
    columns = {
        name: np.delete(values, np.s_[500:520], axis=0) for name, values in run(t, t).items()
    }
    columns["theta"][900:905, 0] = np.nan
    log = read_log(plain_csv(tmp_path / "a.csv", columns))
    theta, tau = log["theta"], log["tau_meas"]
    assert "theta is not a number" in finding(log, "nan").text
    assert "20 samples were dropped in 1 gaps" in finding(log, "gap").text
    # one sample farther on both sides
    missing = (theta.time > t[498]) & (theta.time < t[521])
    assert not tau.valid[missing].any()
    assert tau.valid[~missing].all()
    blank = (theta.time > columns["time"][898]) & (theta.time < columns["time"][906])
    assert not theta.valid[missing | blank].any()
    assert theta.valid[~(missing | blank)].all()
    assert np.isfinite(theta.values).all()
    off = np.abs(theta.values - angle(theta.time))[theta.valid]
    assert off.max() < 1e-4


def test_angle_that_rests_or_runs_straight_says_nothing(tmp_path: Path) -> None:
    t = uneven()
    built = run(t, t)
    built["theta"] = np.column_stack([np.zeros_like(t), 0.1 * np.arange(len(t)) / len(t)])
    built["tau_meas"] = np.zeros((len(t), 2))
    assert "taken as even" in finding(read_log(plain_csv(tmp_path / "a.csv", built)), "jitter").text


def test_motion_without_any_bend_at_its_own_times_tells_no_endless_number(tmp_path: Path) -> None:
    """Times in eighths of milliseconds, at which a straight line is one to the last digit."""
    t = np.round(uneven() * 8192) / 8192
    table = {"time": t, "theta": np.column_stack([2 * t, 3 * t]), "tau_meas": np.zeros((len(t), 2))}
    text = finding(read_log(plain_csv(tmp_path / "a.csv", table)), "jitter").text
    assert "(even times would make the motion 1e+03 times rougher)" in text


def test_log_with_a_long_gap_stays_even(tmp_path: Path) -> None:
    """A break stands for what was skipped; between breaks the times are those that are told."""
    t = uneven()
    cut = {name: np.delete(values, np.s_[500:700], axis=0) for name, values in run(t, t).items()}
    log = read_log(plain_csv(tmp_path / "a.csv", cut))
    assert "taken as even" in finding(log, "jitter").text
    assert "cut there" in finding(log, "break").text


def test_times_that_leave_every_even_clock_are_the_samples(tmp_path: Path) -> None:
    """A loop that takes 5 % longer for a while: by then no even clock is near its stamps. The noise
    of the angles hides how smooth the motion is."""
    rng = np.random.default_rng(6)
    steps = 1e-3 * (1 + 0.05 * np.sin(np.arange(8000) / 800) + 0.2 * (rng.random(8000) - 0.5))
    steps[rng.choice(8000, 40, replace=False)] *= 1.6
    t = np.concatenate([[0.0], np.cumsum(steps)])
    values = run(t, t)
    values["theta"] = values["theta"] + 2e-4 * rng.standard_normal(values["theta"].shape)
    log = read_log(plain_csv(tmp_path / "a.csv", values))
    assert "periods off): values taken in between" in finding(log, "jitter").text
    assert not [f for f in log.findings if f.kind == "gap"]
    theta = log["theta"]
    off = (theta.values - angle(theta.time))[theta.valid]
    assert np.abs(off).max() < 2e-3


def test_late_stamps_and_a_lost_sample_are_near_even_times(tmp_path: Path) -> None:
    even = np.delete(np.arange(4000), 1500) / RATE
    late = even + 4e-3 * np.random.default_rng(7).random(len(even))
    values = run(late, even)
    values["theta"] = values["theta"] + 2e-3 * np.random.default_rng(8).standard_normal((3999, 2))
    log = read_log(plain_csv(tmp_path / "a.csv", values))
    assert "taken as even" in finding(log, "jitter").text
    assert "1 samples were dropped" in finding(log, "gap").text


@pytest.mark.parametrize("share", [0.14, 0.17])
def test_stamps_that_jitter_by_a_part_of_a_period_are_counted(share: float, tmp_path: Path) -> None:
    """Two steps in a hundred are half a period off then, and no sample is lost or added."""
    for seed in range(20):
        noise = share * TS * np.random.default_rng(seed).standard_normal(4000)
        log = read_log(with_time(tmp_path / "a.csv", lambda t, e=noise: np.sort(t + e)))
        assert (len(log.theta), log.ts) == (4000, pytest.approx(TS, rel=1e-4))
        assert log["theta"].valid.all()


def test_sample_that_is_missing_between_stamps_that_jitter_is_one(tmp_path: Path) -> None:
    noise = 0.1 * TS * np.random.default_rng(3).standard_normal(4000)
    gap = np.where(np.arange(4000) > 2000, TS, 0.0)
    log = read_log(with_time(tmp_path / "a.csv", lambda t: t + noise + gap))
    assert len(log.theta) == 4001
    assert np.flatnonzero(~log["theta"].valid).tolist() == [2001]

"""Measured rates and accelerations: used where they are better than differences of the angles."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.logs import Log, group_runs, read_log
from flexhex.diagnosis.runs.differences import motion_of
from flexhex.diagnosis.runs.run import TimeSeries
from flexhex.diagnosis.runs.runs import runs_of
from tests.compare import assert_close

Array = NDArray[np.float64]
TS = 1e-3
T = np.arange(0.0, 8.0, TS)
RATES, PHASES = np.array([2.1, 5.3, 9.7]), np.array([0.3, 1.9, 4.0])


def angle(t: Array) -> Array:
    """[rad]"""
    return np.asarray((0.5 / RATES * np.sin(np.outer(t, RATES) + PHASES)).sum(axis=1))


def rate(t: Array) -> Array:
    return np.asarray((0.5 * np.cos(np.outer(t, RATES) + PHASES)).sum(axis=1))


def acceleration(t: Array) -> Array:
    return np.asarray((-0.5 * RATES * np.sin(np.outer(t, RATES) + PHASES)).sum(axis=1))


def written(path: Path, step: float, units: str = "", **more: Array) -> Log:
    """A log of one axis with an encoder of such steps [rad] and more channels."""
    columns = {"time": T, "theta": np.round(angle(T) / step) * step, "tau_meas": rate(T), **more}
    rows = np.column_stack(list(columns.values()))
    head = f"{','.join(columns)}\ns,rad,N m{units}"
    np.savetxt(path, rows, delimiter=",", header=head, comments="", fmt="%.12g")
    return read_log(path)


def said(log: Log) -> str:
    """The finding on rates or accelerations; one of them."""
    (text,) = [finding.text for finding in log.findings if finding.kind == "rates"]
    return text


def noise(size: float, seed: int = 5) -> Array:
    return np.asarray(size * np.random.default_rng(seed).standard_normal(len(T)))


@pytest.mark.parametrize(("step", "size", "used"), [
    (1e-3, 2e-3, True),
    (1e-5, 2e-2, False),
])  # fmt: skip
def test_rates_are_used_where_their_noise_makes_less(
    step: float, size: float, used: bool, tmp_path: Path
) -> None:
    log = written(tmp_path / "a.csv", step, ",rad/s", thetad=rate(T) + noise(size))
    assert ("thetad" not in log.unused) is used
    assert said(log).startswith("rates are those of thetad" if used else "thetad has")
    # one more differentiation under a Hann window of 16 ms multiplies white noise by 2 pi / 16 ms;
    # the largest 5 % are not counted, which takes 13 % of Gaussian noise and nothing of steps
    times = 0.871 * size / (step / np.sqrt(12.0)) * 0.016 / (2 * np.pi)
    share = float(said(log).partition(" times the noise")[0].rpartition(" ")[2])
    assert share == pytest.approx(times, rel=0.06)  # two digits are told


@pytest.mark.parametrize(("step", "size", "used"), [(1e-4, 0.05, True), (1e-7, 2.0, False)])
def test_accelerations_are_used_where_their_noise_is_less(
    step: float, size: float, used: bool, tmp_path: Path
) -> None:
    more = acceleration(T) + noise(size)
    log = written(tmp_path / "a.csv", step, ",rad/s2", thetadd=more)
    assert ("thetadd" not in log.unused) is used
    assert said(log).endswith("have" if used else "accelerations are differences of theta")


WRONG = {
    "late": (rate(T - 0.008), "thetad[1] comes 8 ms late beside theta[1]"),
    "early": (rate(T + 0.005), "thetad[1] comes 5 ms early beside theta[1]"),
    "degrees": (np.rad2deg(rate(T)), "is it in deg/s (--unit 'thetad=deg/s not rad/s')?"),
    "rpm": (rate(T) * 30 / np.pi, "is it in rpm (--unit 'thetad=rpm not rad/s')?"),
    "turned round": (-rate(T), "thetad[1] is -1 times the rate of theta[1]"),
    "too small": (0.9 * rate(T), "thetad[1] is 0.9 times the rate of theta[1]"),
    "off": (rate(T) + 0.3, "thetad[1] is off the rate of theta[1] by 0.3"),
    "another": (np.cos(31.0 * T), "thetad[1] does not go with theta[1]: another axis?"),
}


@pytest.mark.parametrize("case", WRONG)
def test_rates_that_do_not_go_with_the_angles_are_named_and_not_used(
    case: str, tmp_path: Path
) -> None:
    values, text = WRONG[case]
    log = written(tmp_path / "a.csv", 1e-4, ",rad/s", thetad=values)
    assert log.unused == {"thetad"}
    assert text in said(log)
    assert said(log).endswith("not used, rates are differences of theta")


def test_acceleration_with_the_weight_in_it_is_not_used(tmp_path: Path) -> None:
    log = written(tmp_path / "a.csv", 1e-4, ",rad/s2", thetadd=acceleration(T) + 9.81)
    assert "thetadd[1] is off the acceleration of theta[1] by 9.8" in said(log)


def test_runs_take_no_channel_that_is_not_used(tmp_path: Path) -> None:
    """Rates ten times too large would be ten times the differences of the angles."""
    log = written(tmp_path / "a.csv", 1e-5, ",rad/s", thetad=10 * rate(T))
    (run,) = runs_of(group_runs([log])[:1], 1)
    inner = slice(10, -10)
    assert_close(run.motion.thetad[inner, 0], rate(run.motion.time[inner]), atol=0.02)


def test_missing_samples_of_either_channel_do_not_speak_against_it(tmp_path: Path) -> None:
    holes = rate(T) + noise(1e-3)
    holes[3000:3600] = np.nan  # a straight line stands for them, far from the rate
    log = written(tmp_path / "a.csv", 1e-3, ",rad/s", thetad=holes)
    assert "rates are those of thetad" in said(log)


def signal(values: Array) -> TimeSeries:
    return TimeSeries(0.0, TS, values[:, None], np.ones(len(values), dtype=bool))


def test_measured_accelerations_carry_the_rates_between_the_steps_of_an_encoder(
    tmp_path: Path,
) -> None:
    """Rates of a coarse encoder are wrong by its steps; the integral of accelerations is not, but
    for the slow part, which comes from the angles."""
    log = written(tmp_path / "a.csv", 1e-3, ",rad/s2", thetadd=acceleration(T) + noise(0.02))
    seen = signal(log.theta[:, 0])
    alone, both = motion_of(seen), motion_of(seen, None, log["thetadd"])
    assert_close(both.time, T[2:-2], atol=1e-12)
    inner = slice(60, -60)
    wrong = [np.std(m.thetad[inner, 0] - rate(m.time[inner])) for m in (alone, both)]
    assert wrong[0] > 0.2
    # steps of 1 mrad under 100 ms: 4.4 (1e-3/sqrt 12) sqrt(1 ms / 100 ms) / 100 ms = 1.3 mrad/s
    assert wrong[1] < 3e-3
    assert np.std(both.thetadd[inner, 0] - acceleration(both.time[inner])) < 0.025
    assert (alone.derived, both.derived) == (True, False)


def test_faster_channel_is_averaged_over_the_samples_it_stands_for(tmp_path: Path) -> None:
    log = written(tmp_path / "a.csv", 1e-3, ",rad/s2", thetadd=acceleration(T) + noise(0.5))
    slow = TimeSeries(0.0, 10 * TS, log.theta[::10], np.ones(len(T[::10]), dtype=bool))
    moved = motion_of(slow, None, log["thetadd"])
    off = moved.thetadd[:, 0] - acceleration(moved.time)
    # means of nine samples have a third of the noise
    assert np.std(off) == pytest.approx(0.5 / 3, rel=0.1)

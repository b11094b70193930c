"""Samples that no machine makes are not used: angles that jump or froze, torques of one sample."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexhex.diagnosis.logs import read_log
from flexhex.diagnosis.runs.runs import payload_of, refuse_nothing
from flexhex.fmus.common.errors import LogError
from tests.diagnosis.logs.test_faults import finding
from tests.diagnosis.synthetic import TS, motion, plain_csv


def test_jump_of_an_angle_is_not_valid(tmp_path: Path) -> None:
    """Samples lost while the logger counted on: time shows nothing, the angle does."""
    run = motion()
    run["theta"] = np.vstack([run["theta"][:3000], run["theta"][3200:], run["theta"][-200:]])
    log = read_log(plain_csv(tmp_path / "a.csv", run))
    assert not log["theta"].valid[2999:3001].any()
    assert "jumps" in finding(log, "jump").text


def test_angles_within_a_turn_go_on(tmp_path: Path) -> None:
    """A drive reports them from -pi to pi, or from 0 to 360 degrees; an axis that goes beyond
    jumps there and back."""
    run = motion()
    whole = run["theta"] + [0.0, *[np.pi] * (run["theta"].shape[1] - 1)]
    run["theta"] = (whole + np.pi) % (2 * np.pi) - np.pi
    log = read_log(plain_csv(tmp_path / "a.csv", run))
    assert "theta[2] jumps by a whole turn" in finding(log, "wrapped").text
    assert not [found for found in log.findings if found.kind == "jump"]
    assert log["theta"].valid.all()
    np.testing.assert_allclose(
        np.diff(log["theta"].values, axis=0), np.diff(whole, axis=0), atol=1e-8
    )


def test_jump_of_several_turns_is_left_as_it_is(tmp_path: Path) -> None:
    run = motion()
    run["theta"][2000:, 1] += 10 * 2 * np.pi
    log = read_log(plain_csv(tmp_path / "a.csv", run))
    assert not [found for found in log.findings if found.kind == "wrapped"]
    np.testing.assert_allclose(log["theta"].values[:, 1], run["theta"][:, 1], atol=1e-6)


def test_readings_that_froze_are_not_valid(tmp_path: Path) -> None:
    """They stand still to the last digit, and then jump to where the axis is; rest does not."""
    run = motion()
    run["theta"][2000:2500, 1] = run["theta"][2000, 1]
    run["theta"][-300:] = run["theta"][-300]
    log = read_log(plain_csv(tmp_path / "a.csv", run))
    frozen = np.flatnonzero(~log["theta"].valid)
    assert frozen.tolist() == list(range(2000, 2501))
    assert "it stands still for 0.25 s before: frozen, not used" in finding(log, "jump").text


def test_single_damaged_torques_are_not_valid(tmp_path: Path) -> None:
    """Of a step, as friction makes at a reversal, and of noise all samples are used."""
    run, rng = motion(), np.random.default_rng(3)
    run["tau_meas"][1500:, 0] += 50 * np.ptp(run["tau_meas"][:, 0])
    run["tau_meas"][:, 1] += 0.1 * rng.standard_t(3, len(run["time"]))
    run["tau_meas"][[300, 1700, 2900], 1] += [20.0, -20.0, 20.0]
    log = read_log(plain_csv(tmp_path / "a.csv", run))
    assert np.flatnonzero(~log["tau_meas"].valid).tolist() == [300, 1700, 2900]
    found = finding(log, "spike")
    assert "tau_meas[2] has 3 spikes of a single sample, first at 0.15 s: not used" in found.text


def test_values_that_a_logger_repeats_are_read_at_their_own_rate(tmp_path: Path) -> None:
    """The drive is read every third sample, beginning with the third one; steps of an encoder come
    as they come, and a command is held by the drive."""
    run = motion()
    once = run["theta"].copy()
    run["theta"][2:] = np.repeat(once[2::3], 3, axis=0)[: len(once) - 2]
    run["theta"][:2] = once[0]
    run["tau_meas"] = np.round(run["tau_meas"], 2)
    run["tau"] = np.repeat(run["tau_meas"][::2], 2, axis=0)
    log = read_log(plain_csv(tmp_path / "a.csv", run))
    theta = log["theta"]
    assert finding(log, "held").text == "theta changes every 3 samples alone: read at that rate"
    np.testing.assert_allclose((theta.t0, theta.ts), (2 * TS, 3 * TS))
    np.testing.assert_allclose(theta.values, once[2::3], atol=1e-9)
    assert [len(log[name].values) for name in ("tau_meas", "tau")] == [len(once)] * 2


@pytest.mark.parametrize(
    ("told", "mass"), [("0.8", 0.8), ("0.8 kg", 0.8), ("800 g", 0.8), (".5kg", 0.5), ("0", 0.0)]
)
def test_payload_in_the_head_is_in_kg(told: str, mass: float, tmp_path: Path) -> None:
    path = plain_csv(tmp_path / "a.csv", motion())
    path.write_text(f"# payload: {told}\n{path.read_text()}")
    assert payload_of(read_log(path)) == pytest.approx(mass)


@pytest.mark.parametrize("told", ["2 lb", "heavy", "-5 kg", "nan", "0.8 kg g"])
def test_payload_that_is_none_is_refused(told: str, tmp_path: Path) -> None:
    path = plain_csv(tmp_path / "a.csv", motion())
    path.write_text(f"# payload: {told}\n{path.read_text()}")
    with pytest.raises(LogError, match=rf"a\.csv: payload is '{told}', wanted in kg or g"):
        read_log(path)


def test_torque_that_is_nothing_is_refused(tmp_path: Path) -> None:
    run = motion()
    run["tau_meas"] *= 1e-40
    log = read_log(plain_csv(tmp_path / "a.csv", run))
    with pytest.raises(LogError, match=r"tau_meas is nowhere larger than .*e-4\d: is it in the"):
        refuse_nothing(log)

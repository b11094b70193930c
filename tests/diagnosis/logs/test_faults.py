"""What goes wrong on a real machine's logs is noticed, mended where that is safe, and said."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from flexhex.diagnosis.logs import Finding, Log, read_log
from flexhex.diagnosis.logs.values import plateaus
from flexhex.fmus.common.errors import LogError
from tests.diagnosis.synthetic import TS, Array, columns, motion, plain_csv, write_csv


def finding(log: Log, kind: str) -> Finding:
    """The one finding of a kind."""
    (one,) = [f for f in log.findings if f.kind == kind]
    return one


def with_time(path: Path, change: Callable[[Array], Array], seconds: float = 2.0) -> Path:
    run = motion(seconds)
    return plain_csv(path, {**run, "time": change(run["time"])})


def test_clean_log_has_no_finding(tmp_path: Path) -> None:
    run = motion()
    log = read_log(plain_csv(tmp_path / "a.csv", {**run, "r": run["theta"]}))
    assert log.findings == ()
    assert log["theta"].valid.all()
    assert log.ts == pytest.approx(TS, rel=1e-12)


def test_nan_stretch_is_bridged_and_not_valid(tmp_path: Path) -> None:
    run = motion()
    run["theta"][1000:1050, 1] = np.nan
    channel = (log := read_log(plain_csv(tmp_path / "a.csv", run)))["theta"]
    assert np.flatnonzero(~channel.valid).tolist() == list(range(1000, 1050))
    assert np.isfinite(channel.values).all()
    assert "50 samples (1 stretches, the first at 0.5 s)" in finding(log, "nan").text
    assert log["tau_meas"].valid.all()


def test_value_that_nothing_can_have_is_missing(tmp_path: Path) -> None:
    """As a damaged file holds them; the time is one of them, too."""
    run = motion()
    run["theta"][200, 0], run["time"][300] = -1.1e282, 2.7e154
    read = read_log(plain_csv(tmp_path / "a.csv", run))
    texts = [f.text for f in read.findings if f.kind == "nan"]
    assert any("theta[1] is -1.1e+282 in sample 201" in text for text in texts)
    assert any("time is 2.7e+154 in sample 301" in text for text in texts)
    assert np.abs(read["theta"].values).max() < 20.0
    assert not read["theta"].valid[200]


def test_channel_without_any_number_is_refused_or_left_out(tmp_path: Path) -> None:
    run = motion()
    nothing = np.full_like(run["theta"], np.nan)
    log = read_log(plain_csv(tmp_path / "a.csv", {**run, "r": nothing}))
    assert "r holds no numbers" in finding(log, "nan").text
    with pytest.raises(LogError, match="theta holds no sample in which all axes are numbers"):
        read_log(plain_csv(tmp_path / "b.csv", {**run, "theta": nothing}))


def test_dropped_samples_leave_the_others_in_their_place(tmp_path: Path) -> None:
    run = motion()
    lost = np.r_[500:503, 2000, 2002]
    cut = {name: np.delete(signal, lost, axis=0) for name, signal in run.items()}
    log = read_log(plain_csv(tmp_path / "a.csv", cut))
    channel = log["theta"]
    assert np.flatnonzero(~channel.valid).tolist() == lost.tolist()
    assert np.array_equal(channel.values[channel.valid], cut["theta"])
    # a straight line over two periods of a motion of 12 rad/s: 0.1 rad (12 2 TS)^2 / 2
    assert np.abs(channel.values - run["theta"]).max() < 1e-4
    assert finding(log, "gap").text.startswith("5 samples were dropped in 3 gaps")


def test_long_gap_is_a_break_with_true_times(tmp_path: Path) -> None:
    run = motion()
    cut = {name: np.delete(signal, np.s_[1000:4000], axis=0) for name, signal in run.items()}
    log = read_log(plain_csv(tmp_path / "a.csv", cut))
    channel = log["theta"]
    assert np.flatnonzero(~channel.valid).tolist() == [1000]
    assert channel.time[channel.valid] == pytest.approx(cut["time"], abs=1e-9)
    assert np.array_equal(channel.values[channel.valid], cut["theta"])
    assert "cut there" in finding(log, "break").text


def test_time_backwards_is_refused_but_a_reset_is_cut(tmp_path: Path) -> None:
    with pytest.raises(LogError, match="time runs backwards 3999 times, first from"):
        read_log(with_time(tmp_path / "a.csv", lambda t: t[::-1]))
    log = read_log(with_time(tmp_path / "a.csv", lambda t: np.where(t < 0.5, t, t - 0.5)))
    assert len(log.theta) == 3000
    assert "set back 1 times (first in sample 1001)" in finding(log, "reset").text
    with pytest.raises(LogError, match="stands still"):
        read_log(with_time(tmp_path / "a.csv", np.zeros_like))
    mixed = np.random.default_rng(0).permutation(4000)
    with pytest.raises(LogError, match="backwards"):
        read_log(with_time(tmp_path / "a.csv", lambda t: t[mixed]))


def test_jitter_is_reported_and_loses_no_sample(tmp_path: Path) -> None:
    noise = 0.1 * TS * np.random.default_rng(1).standard_normal(4000)
    log = read_log(with_time(tmp_path / "a.csv", lambda t: t + noise))
    assert "jitters by 5e-05 s" in finding(log, "jitter").text
    assert (len(log.theta), log.ts) == (4000, pytest.approx(TS, rel=1e-4))
    assert log["theta"].valid.all()
    with pytest.raises(LogError, match=r"not evenly spaced: .* interpolate all channels"):
        read_log(with_time(tmp_path / "a.csv", lambda t: np.sort(t + 20 * noise)))


def test_coarsely_written_time_is_counted(tmp_path: Path) -> None:
    log = read_log(with_time(tmp_path / "a.csv", lambda t: np.round(t, 3)))
    assert log.ts == pytest.approx(TS, rel=1e-4)
    assert "steps of 0.001 s" in finding(log, "jitter").text


def test_repeated_samples_are_dropped(tmp_path: Path) -> None:
    run = motion()
    twice = {name: np.insert(s, 300, s[300], axis=0) for name, s in run.items()}
    log = read_log(plain_csv(tmp_path / "a.csv", twice))
    assert np.array_equal(log.theta, run["theta"])
    assert finding(log, "duplicate").corrected


def test_drift_between_time_columns_is_reported(tmp_path: Path) -> None:
    run = motion()
    values = np.column_stack([run["time"], run["theta"], run["time"] * (1 + 2e-4), run["tau_meas"]])
    names = ["time", "theta[1]", "theta[2]", "time", "tau_meas[1]", "tau_meas[2]"]
    units = ["s", "rad", "rad", "s", "N m", "N m"]
    log = read_log(write_csv(tmp_path / "a.csv", names, units, values))
    assert "drift by 200 ppm" in finding(log, "drift").text
    assert log["tau_meas"].ts / log.ts == pytest.approx(1 + 2e-4, rel=1e-9)


def test_a_rounded_peak_is_not_clipped() -> None:
    """Slow waves in coarse steps stand at their largest value for long."""
    rng, t = np.random.default_rng(4), TS * np.arange(6000)
    flat = []
    for _ in range(60):
        size, w, phase = rng.uniform([0.2, 0.5, 0.0], [1.0, 9.0, 6.0], (4, 3)).T
        wave = np.sin(w * t[:, None] + phase) @ size
        step = 10 ** rng.uniform(-3, -1)
        flat.append(plateaus(np.round(wave / step) * step, np.ones(len(t), dtype=bool)).any())
    assert not any(flat)


def test_clipped_torque_is_not_valid_but_a_peak_is(tmp_path: Path) -> None:
    run = motion()
    step = 1e-3  # a drive's step of current times its torque constant
    clean = step * np.rint(run["tau_meas"] / step)
    smooth = step * np.rint(np.sin(3 * run["time"])[:, None] * [1, 0.5] / step)
    for torque in (clean, smooth):
        log = read_log(plain_csv(tmp_path / "a.csv", {**run, "tau_meas": torque}))
        assert log["tau_meas"].valid.all()
        clipped = np.clip(torque, -0.7 * torque.max(), np.inf)
        log = read_log(plain_csv(tmp_path / "a.csv", {**run, "tau_meas": clipped}))
        at = (clipped == clipped.min()).any(axis=1)
        assert not log["tau_meas"].valid[at].any()
        assert (~log["tau_meas"].valid).sum() < 1.5 * at.sum() + 50
        assert "is clipped at -" in next(f.text for f in log.findings if f.kind == "clipped")


def test_constant_channel_and_doubtful_range_are_reported(tmp_path: Path) -> None:
    run = motion()
    run["tau_meas"][:, 1] = 0.25
    run["theta"][:, 0] *= 1000
    log = read_log(plain_csv(tmp_path / "a.csv", run))
    assert finding(log, "constant").text == "tau_meas[2] is 0.25 throughout"
    assert "theta[1] reaches" in finding(log, "range").text


def test_swapped_axes_and_turned_signs_are_reported(tmp_path: Path) -> None:
    run = motion(n=3)
    swapped = run["theta"][:, [1, 0, 2]] * [1, 1, -1]
    log = read_log(plain_csv(tmp_path / "a.csv", {**run, "theta": swapped, "r": run["theta"]}))
    assert finding(log, "swapped").text == (
        "axes are swapped: theta[1] follows r[2], theta[2] follows r[1]"
    )
    assert "theta[3] follows -r[3]" in finding(log, "sign").text


def test_delay_and_growing_delay_are_measured(tmp_path: Path) -> None:
    """To a fiftieth of a sample; interpolation of the made-up signal is far better."""
    run = motion(6.0)
    t = run["time"]
    longer = motion(8.0)
    fine, known = longer["theta"].T, longer["time"]
    late = np.column_stack([np.interp(t - 0.0123, known, column) for column in fine])
    log = read_log(plain_csv(tmp_path / "a.csv", {**run, "r": run["theta"], "theta": late}))
    text = finding(log, "delay").text
    assert float(text.split(" by ")[1].split()[0]) == pytest.approx(12.3, abs=0.01)
    grown = np.column_stack([np.interp(t * (1 - 1e-3), known, column) for column in fine])
    log = read_log(plain_csv(tmp_path / "a.csv", {**run, "r": run["theta"], "theta": grown}))
    text = finding(log, "drift").text
    assert float(text.split("drift by ")[1].split()[0]) == pytest.approx(1000, rel=0.02)
    # a feedback's lag goes with the motion: it grows, but not evenly
    lag = 0.002 + 0.006 * (t / t[-1]) ** 3
    bent = np.column_stack([np.interp(t - lag, known, column) for column in fine])
    log = read_log(plain_csv(tmp_path / "a.csv", {**run, "r": run["theta"], "theta": bent}))
    assert not [each for each in log.findings if each.kind == "drift"]


def test_missing_channels_are_named(tmp_path: Path) -> None:
    run = motion(0.5)
    for lost, match in (
        ("tau_meas", r"no channels tau_meas\[1\]"),
        ("time", "no channel `time`.*, --rename 'COLUMN=time'"),
    ):
        kept = {name: signal for name, signal in run.items() if name != lost}
        with pytest.raises(LogError, match=match):
            read_log(plain_csv(tmp_path / "a.csv", kept))
    names, units, values = columns(motion(0.5, n=3))
    keep = [0, 1, 3, 4, 5, 6]
    with pytest.raises(LogError, match=r"theta\[2\] is missing"):
        read_log(
            write_csv(
                tmp_path / "a.csv",
                [names[k] for k in keep],
                [units[k] for k in keep],
                values[:, keep],
            )
        )
    with pytest.raises(LogError, match=r"3 angles but 2 torques: axis 3 has no torque"):
        read_log(write_csv(tmp_path / "a.csv", names[:6], units[:6], values[:, :6]))


def test_short_log_is_reported_or_refused(tmp_path: Path) -> None:
    assert finding(read_log(plain_csv(tmp_path / "a.csv", motion(0.5))), "short")
    with pytest.raises(LogError, match="2 samples are too few"):
        read_log(plain_csv(tmp_path / "a.csv", motion(2 * TS)))

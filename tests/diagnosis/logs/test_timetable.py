"""CSV as MATLAB's `writetimetable` writes it: durations with their unit in every row."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexhex.diagnosis.logs import Options, read_log
from flexhex.fmus.common.errors import LogError
from tests.compare import assert_close

T = np.arange(600) * 0.002
Q, TAU = np.column_stack([np.sin(3 * T), np.cos(5 * T)]), np.column_stack([T, 1 - T])
UNITS = {"theta": "rad", "tau_meas": "N m"}


def written(path: Path, time: str = "{:.10g} sec", names: str = "") -> Path:
    lines = [names or "Time,theta_1,theta_2,tau_meas_1,tau_meas_2"]
    for t, row in zip(T, np.hstack([Q, TAU]), strict=True):
        lines.append(",".join([time.format(t), *(f"{v:.12g}" for v in row)]))
    path.write_text("\r\n".join([*lines, ""]))
    return path


def test_durations_are_seconds(tmp_path: Path) -> None:
    log = read_log(written(tmp_path / "a.csv"), Options(units=UNITS))
    assert_close(log.ts, 0.002, rtol=1e-9)
    assert_close(log.theta, Q, atol=1e-11)
    assert_close(log.tau, TAU, atol=1e-11)


def test_units_of_the_head_count(tmp_path: Path) -> None:
    names = "Time,theta_1 (deg),theta_2 (deg),tau_meas_1 (Nm),tau_meas_2 (Nm)"
    log = read_log(written(tmp_path / "a.csv", names=names))
    assert_close(log.theta, np.deg2rad(Q), atol=1e-11)


def test_units_alone_are_asked_for(tmp_path: Path) -> None:
    with pytest.raises(LogError, match=r"^(?!.*time).*theta has no unit.*; tau_meas has no unit"):
        read_log(written(tmp_path / "a.csv"))


def test_clock_times_say_how_to_write_seconds(tmp_path: Path) -> None:
    with pytest.raises(LogError, match=r"'00:00:0' is a clock time.*TT.Time.Format = 's'"):
        read_log(written(tmp_path / "a.csv", "00:00:{:.10g}"), Options(units=UNITS))

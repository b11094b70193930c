"""Logs as common robots write them: read as they are, with the units of their makers."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.logs import Options, read_log
from flexhex.fmus.common.errors import LogError
from tests.compare import assert_close

Array = NDArray[np.float64]
T = np.arange(400) * 0.002
Q = np.sin(np.outer(T, (1.0, 2.0))) + 0.1
TAU = np.cos(np.outer(T, (5.0, 3.0)))


def written(path: Path, columns: dict[str, Array], separator: str = ",") -> Path:
    """A CSV without a row of units."""
    rows = np.column_stack(list(columns.values()))
    head = separator.join(columns)
    np.savetxt(path, rows, delimiter=separator, header=head, comments="", fmt="%.12g")
    return path


def axes(name: str, values: Array, first: int = 0, form: str = "{}_{}") -> dict[str, Array]:
    return {form.format(name, k + first): values[:, k] for k in range(values.shape[1])}


def ur() -> dict[str, Array]:
    """As `record.py` writes it: seconds since the robot was switched on."""
    return {
        "timestamp": 5120.0 + T,
        **axes("target_q", Q + 0.01),
        **axes("actual_q", Q),
        **axes("actual_qd", Q * 2),
        **axes("actual_current", TAU),
        **axes("actual_TCP_pose", Q),
    }


@pytest.mark.parametrize("separator", [",", " "], ids=["ur_rtde", "record.py"])
def test_universal_robots_want_the_torque_constants_alone(separator: str, tmp_path: Path) -> None:
    path = written(tmp_path / "ur.csv", ur(), separator)
    with pytest.raises(LogError, match="no torque constant is known"):
        read_log(path)
    log = read_log(path, Options(torque_constant=(10.0, 12.0)))
    assert_close(log.theta, Q, atol=1e-9)
    assert_close(log.tau, TAU * (10.0, 12.0), atol=1e-9)
    assert_close(log["r"].values, Q + 0.01, atol=1e-9)
    assert_close(log["thetad"].values, Q * 2, atol=1e-9)
    said = [str(finding) for finding in log.findings if finding.kind == "names"]
    assert any("columns of UR RTDE: timestamp as time, actual_q as theta" in text for text in said)


def test_kuka_is_read_as_it_is(tmp_path: Path) -> None:
    columns = {"index": np.arange(400.0), "time": T, "record_time_nsec": T * 1e9}
    for name, values in (("mp", Q), ("ip", Q + 0.01), ("mt", TAU), ("et", TAU)):
        columns |= axes(name, values, 1, "{}{}")
    log = read_log(written(tmp_path / "kuka.csv", columns))
    assert_close(log.theta, Q, atol=1e-9)
    assert_close(log.tau, TAU, atol=1e-9)
    assert_close(log["r"].values, Q + 0.01, atol=1e-9)


def test_franka_is_asked_for_the_unit_of_its_time(tmp_path: Path) -> None:
    columns = {"time": T * 1e3}
    for name, values in (("q", Q), ("dq", Q * 2), ("tau_J", TAU), ("q_d", Q), ("tau_ext", TAU)):
        columns |= axes(name, values, 0, "{}[{}]")
    path = written(tmp_path / "franka.csv", columns)
    with pytest.raises(LogError, match="--unit time=s"):
        read_log(path)
    log = read_log(path, Options(units={"time": "ms"}))
    assert_close(log.theta, Q, atol=1e-9)
    assert_close(log.tau, TAU, atol=1e-9)
    assert_close(log.ts, 0.002, rtol=1e-6)


@pytest.mark.parametrize(("rate", "acceleration"), [("qd", "qdd"), ("dq", "ddq")])
def test_symbols_of_textbooks_want_their_units_at_once(
    rate: str, acceleration: str, tmp_path: Path
) -> None:
    columns = {"time": T}
    for name, values in (("q", Q), (rate, Q * 2), (acceleration, Q * 3), ("tau", TAU)):
        columns |= axes(name, values, 0, "{}{}")
    path = written(tmp_path / "lab.csv", columns)
    wanted = ".*".join(f"--unit {name}=" for name in ("time", "theta", "tau_meas"))
    with pytest.raises(LogError, match=wanted):
        read_log(path)
    units = {"time": "s", "theta": "deg", "thetad": "deg/s", "thetadd": "deg/s2", "tau_meas": "N m"}
    log = read_log(path, Options(units=units))
    assert_close(log.theta, np.deg2rad(Q), atol=1e-9)
    assert_close(log["thetad"].values, np.deg2rad(Q * 2), atol=1e-9)
    assert_close(log["thetadd"].values, np.deg2rad(Q * 3), atol=1e-9)
    assert_close(log.tau, TAU, atol=1e-9)


def test_names_of_the_user_and_of_ours_come_first(tmp_path: Path) -> None:
    columns = {"time": T, **axes("theta", Q), **axes("tau_meas", TAU), **axes("q", Q + 1.0)}
    path = written(tmp_path / "ours.csv", columns | axes("tau_J", TAU))
    units = {"time": "s", "theta": "rad", "tau_meas": "N m"}
    assert_close(read_log(path, Options(units=units)).theta, Q, atol=1e-9)
    path = written(tmp_path / "ur.csv", ur())
    names = {"timestamp": "time", "target_q": "theta", "actual_current": "tau_meas"}
    log = read_log(path, Options(units=units, rename=names))
    assert_close(log.theta, Q + 0.01, atol=1e-9)


def test_units_of_the_file_outweigh_the_makers(tmp_path: Path) -> None:
    columns = {"time": T, **axes("mp", Q, 1, "{}{}"), **axes("mt", TAU, 1, "{}{}")}
    path = written(tmp_path / "kuka.csv", columns)
    head, *rows = path.read_text().splitlines()
    path.write_text("\n".join([head, "s,deg,deg,N m,N m", *rows]))
    assert_close(read_log(path).theta, np.deg2rad(Q), atol=1e-9)

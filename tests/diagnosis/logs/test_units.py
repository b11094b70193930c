"""Units of a log: converted where they have one meaning, refused where they have several."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest
from scipy.io import savemat

from flexhex.diagnosis.logs import Options, read_log
from flexhex.diagnosis.planning.trajectory import read_trajectory
from flexhex.fmus.common.errors import LogError
from tests.diagnosis.logs.test_faults import finding
from tests.diagnosis.synthetic import TS, columns, motion, plain_csv, write_csv, write_hdf5


@pytest.mark.parametrize(
    ("unit", "factor"), [("deg", np.pi / 180), ("mrad", 1e-3), ("°", np.pi / 180), ("µrad", 1e-6)]
)
def test_unit_with_one_meaning_is_converted_and_said(
    unit: str, factor: float, tmp_path: Path
) -> None:
    names, units, values = columns(motion())
    units = ["ms", unit, unit, "mNm", "mNm"]
    values[:, 0] *= 1e3
    log = read_log(write_csv(tmp_path / "a.csv", names, units, values))
    assert log.theta == pytest.approx(values[:, 1:3] * factor, rel=1e-15)
    assert log.tau == pytest.approx(values[:, 3:] * 1e-3, rel=1e-15)
    assert log.ts == pytest.approx(TS)
    assert [f.text for f in log.findings if f.kind == "units"] == [
        f"theta converted from {unit} to rad",
        "tau_meas converted from mNm to N m",
    ]


@pytest.mark.parametrize("unit", ["Nmm", "grad", "counts", "%", "1", "furlong", "Mrad", "in"])
def test_unit_with_several_meanings_is_refused(unit: str, tmp_path: Path) -> None:
    names, _, values = columns(motion(0.5))
    for units in (["s", unit, unit, "N m", "N m"], ["s", "rad", "rad", unit, unit]):
        with pytest.raises(LogError, match=rf"a\.csv: .*\[1\] is in '{unit}', wanted .*--unit"):
            read_log(write_csv(tmp_path / "a.csv", names, units, values))


def test_log_without_units_is_refused_with_the_way_out(tmp_path: Path) -> None:
    names, _, values = columns(motion())
    path = write_csv(tmp_path / "a.csv", names, None, values)
    with pytest.raises(LogError, match=r"has no unit, wanted 's': give it in the file .* --unit"):
        read_log(path)
    options = Options(units={"time": "s", "theta": "deg", "tau_meas": "N m"})
    assert read_log(path, options).theta == pytest.approx(values[:, 1:3] * np.pi / 180)


def test_current_needs_a_torque_constant(tmp_path: Path) -> None:
    names, _, values = columns(motion())
    for channel in ("tau_meas", "current"):
        named = [name.replace("tau_meas", channel) for name in names]
        units = ["s", "rad", "rad", "mA", "mA"]
        path = write_csv(tmp_path / "a.csv", named, units, values)
        with pytest.raises(LogError, match=r"no torque constant .* 3\.0 N m/A"):
            read_log(path)
        given = read_log(path, Options(torque_constant=(3.0, 2.0)))
        assert given.tau == pytest.approx(values[:, 3:] * [3e-3, 2e-3])
        meta = {"torque_constant": "3.0 N m/A"}
        log = read_log(write_csv(tmp_path / "a.csv", named, units, values, meta))
        assert log.tau == pytest.approx(values[:, 3:] * 3e-3)
        assert "3 N m/A" in finding(log, "units").text
        turned = {"torque_constant": "3.0, -2.0 N m/A"}
        log = read_log(write_csv(tmp_path / "a.csv", named, units, values, turned))
        assert log.tau == pytest.approx(values[:, 3:] * [3e-3, -2e-3])
        for bad in ("3.0", "3.0 V", "nan N m/A", "0 N m/A", "", "x N m/A"):
            path = write_csv(
                tmp_path / "a.csv", named, units, values, {"torque_constant": bad or " "}
            )
            with pytest.raises(LogError, match="torque_constant is"):
                read_log(path)


def test_volts_are_relative_without_a_constant(tmp_path: Path) -> None:
    names, _, values = columns(motion())
    path = write_csv(tmp_path / "a.csv", names, ["s", "m", "m", "mV", "mV"], values)
    log = read_log(path)
    assert log.tau == pytest.approx(values[:, 3:] * 1e-3)
    assert "all results are relative, in volts" in finding(log, "units").text
    given = read_log(path, Options(torque_constant=35.0))
    assert given.tau == pytest.approx(values[:, 3:] * 35e-3)
    assert "tau_meas in V times the torque constant 35 N/V" in finding(given, "units").text


def test_volts_and_amperes_are_not_taken_for_each_other(tmp_path: Path) -> None:
    names, _, values = columns(motion())
    path, units = tmp_path / "a.csv", ["s", "rad", "rad", "V", "V"]
    log = read_log(write_csv(path, names, units, values, {"torque_constant": "3 N m/V"}))
    assert log.tau == pytest.approx(values[:, 3:] * 3.0)
    with pytest.raises(LogError, match=r"is in V, torque_constant is '3 N m/A'"):
        read_log(write_csv(path, names, units, values, {"torque_constant": "3 N m/A"}))
    with pytest.raises(LogError, match="in A on some axes, in V on others"):
        read_log(write_csv(path, names, ["s", "rad", "rad", "V", "A"], values))


def as_hdf5(path: Path, unit: str) -> Path:
    write_hdf5(path, motion())
    with h5py.File(path, "a") as file:
        file["theta"].attrs["unit"] = unit
    return path


def as_csv(path: Path, unit: str) -> Path:
    names, _, values = columns(motion())
    return write_csv(path, names, ["s", unit, unit, "N m", "N m"], values)


def as_mat(path: Path, unit: str) -> Path:
    units = {"time": "s", "theta": unit, "tau_meas": "N m"}
    savemat(path, {**motion(), "unit": units})
    return path


@pytest.mark.parametrize(("kind", "written"), [("csv", as_csv), ("h5", as_hdf5), ("mat", as_mat)])
def test_unit_of_the_user_contradicts_no_file(
    kind: str, written: Callable[[Path, str], Path], tmp_path: Path
) -> None:
    """It would be 57 times the angle without a word."""
    path = written(tmp_path / f"a.{kind}", "rad")
    with pytest.raises(LogError, match=r"theta is in rad as the file states, but --unit says deg"):
        read_log(path, Options(units={"theta": "deg"}))
    equal = read_log(path, Options(units={"theta": "rad", "tau_meas": "Nm"}))
    assert equal.theta == pytest.approx(motion()["theta"])
    assert not [f for f in equal.findings if f.kind == "units"]
    # what the message says mends it, and is said
    log = read_log(path, Options(units={"theta": "deg not rad"}))
    assert log.theta == pytest.approx(np.deg2rad(motion()["theta"]))
    assert "theta taken as deg, as --unit says, not as rad of the file" in str(log.findings[0])
    with pytest.raises(LogError, match=r"--unit 'theta=deg not rad' says it"):
        read_log(path, Options(units={"theta": "deg not mm"}))


def test_unit_of_the_user_fills_what_the_file_leaves_open(tmp_path: Path) -> None:
    names, _, values = columns(motion())
    path = write_csv(tmp_path / "a.csv", names, ["s", "counts", "", "N m", "N m"], values)
    log = read_log(path, Options(units={"theta": "rev/65536,rad"}))
    assert log.theta == pytest.approx(values[:, 1:3] * [2 * np.pi / 65536, 1.0])
    mixed = write_csv(tmp_path / "b.csv", names, ["s", "rad", "", "A", "A"], values)
    with pytest.raises(LogError, match=r"but --unit says mm: .*'theta=mm not rad,'"):
        read_log(mixed, Options(units={"theta": "mm"}))
    with pytest.raises(LogError, match="tau_meas is in A as the file states, but --unit says N m"):
        read_log(path.parent / "b.csv", Options(units={"theta": "rad", "tau_meas": "N m"}))


def test_time_of_the_user_contradicts_no_file(tmp_path: Path) -> None:
    path = plain_csv(tmp_path / "a.csv", motion())
    for read in (read_log, read_trajectory):
        with pytest.raises(LogError, match="time is in s as the file states, but --unit says ms"):
            read(path, Options(units={"time": "ms"}))
    log = read_log(path, Options(units={"time": "ms not s"}))
    assert log.ts == pytest.approx(1e-3 * TS)
    assert "time taken as ms" in str(log.findings[0])

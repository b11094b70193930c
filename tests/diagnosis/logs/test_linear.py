"""Logs of axes that slide, and of machines with axes of both kinds: everything is SI once read."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest

from flexhex.diagnosis.kinds import LINEAR, ROTARY, powers
from flexhex.diagnosis.logs import Log, Options, group_runs, read_log
from flexhex.diagnosis.planning.trajectory import Trajectory, read_trajectory, write_trajectory
from flexhex.fmus.common.effects import library
from flexhex.fmus.common.errors import LogError
from tests.diagnosis.synthetic import columns, motion, write_csv


def said(log: Log) -> list[str]:
    """What a log says of its units."""
    return [finding.text for finding in log.findings if finding.kind == "units"]


@pytest.mark.parametrize(
    ("length", "force", "factors"),
    [
        ("m", "N", (1.0, 1.0)),
        ("mm", "kN", (1e-3, 1e3)),
        ("um", "mN", (1e-6, 1e-3)),
        ("µm", "N", (1e-6, 1.0)),
        ("nm", "uN", (1e-9, 1e-6)),
    ],
)
def test_lengths_and_forces_become_m_and_n(
    length: str, force: str, factors: tuple[float, float], tmp_path: Path
) -> None:
    names, _, values = columns(motion())
    units = ["s", length, length, force, force]
    log = read_log(write_csv(tmp_path / "a.csv", names, units, values))
    assert log.kinds == (LINEAR, LINEAR)
    assert log.theta == pytest.approx(values[:, 1:3] * factors[0], rel=1e-15)
    assert log.tau == pytest.approx(values[:, 3:] * factors[1], rel=1e-15)
    assert any("to m" in text for text in said(log)) == (length != "m")


def test_speeds_become_m_per_s(tmp_path: Path) -> None:
    run = motion(n=1)
    names = ["time", "theta[1]", "thetad[1]", "tau_meas[1]"]
    rate = np.gradient(run["theta"], run["time"], axis=0)
    values = np.column_stack([run["time"], 1e3 * run["theta"], 1e3 * rate, run["tau_meas"]])
    log = read_log(write_csv(tmp_path / "a.csv", names, ["s", "mm", "mm/s", "N"], values))
    assert log["thetad"].values == pytest.approx(rate)
    other = read_log(write_csv(tmp_path / "b.csv", names, ["s", "mm", "rad/s", "N"], values))
    assert "thetad" not in other.channels
    assert "wants 'm/s' here" in said(other)[-1]


def test_each_axis_has_a_unit_of_its_own(tmp_path: Path) -> None:
    names, _, values = columns(motion())
    mixed = write_csv(tmp_path / "a.csv", names, ["s", "deg", "mm", "mNm", "kN"], values)
    log = read_log(mixed)
    assert log.kinds == (ROTARY, LINEAR)
    assert log.theta == pytest.approx(values[:, 1:3] * [np.pi / 180, 1e-3])
    assert log.tau == pytest.approx(values[:, 3:] * [1e-3, 1e3])
    assert said(log)[0] == "theta[1] converted from deg to rad, theta[2] converted from mm to m"
    plain = write_csv(tmp_path / "b.csv", names, None, values)
    units = {"time": "s", "theta": "deg, mm", "tau_meas": "mNm,kN"}
    assert (read_log(plain, Options(units=units)).tau == log.tau).all()
    with pytest.raises(LogError, match=r"theta has 3 units \(deg,mm,mm\) for 2 axes"):
        read_log(plain, Options(units={**units, "theta": "deg,mm,mm"}))


@pytest.mark.parametrize("unit", ["rad, mm", ["rad", "mm"]])
def test_arrays_tell_the_unit_of_each_axis(unit: str | list[str], tmp_path: Path) -> None:
    run = motion()
    path = tmp_path / "a.h5"
    force = ["N m", "N"] if isinstance(unit, list) else "N m, N"
    with h5py.File(path, "w") as file:
        for name, units in (("time", "s"), ("theta", unit), ("tau_meas", force)):
            file[name] = run[name]
            file[name].attrs["unit"] = units
    log = read_log(path)
    assert log.kinds == (ROTARY, LINEAR)
    assert log.theta == pytest.approx(run["theta"] * [1.0, 1e-3])


def test_one_torque_among_forces_is_refused(tmp_path: Path) -> None:
    names, _, values = columns(motion())
    path = write_csv(tmp_path / "a.csv", names, ["s", "mm", "mm", "N", "N m"], values)
    with pytest.raises(LogError, match=r"a\.csv: tau_meas\[2\] is in 'N m', but theta\[2\] .*'N'"):
        read_log(path)


def test_currents_of_a_linear_motor_want_a_force_constant(tmp_path: Path) -> None:
    names, _, values = columns(motion())
    units = ["s", "deg", "mm", "A", "A"]
    path = tmp_path / "a.csv"
    right = {"torque_constant": "3.0 N m/A, 60 N/A"}
    log = read_log(write_csv(path, names, units, values, right))
    assert log.tau == pytest.approx(values[:, 3:] * [3.0, 60.0])
    assert "tau_meas in A times the torque constant 3 N m/A, 60 N/A" in said(log)
    given = read_log(write_csv(path, names, units, values), Options(torque_constant=(3.0, 60.0)))
    assert (given.tau == log.tau).all()
    wrong = {"torque_constant": "3.0, 60 N m/A"}
    with pytest.raises(LogError, match=r"torque_constant is '3\.0, .* wanted in N m/A, N/A"):
        read_log(write_csv(path, names, units, values, wrong))


def test_passes_of_a_stage_that_moves_a_micrometre_are_found(tmp_path: Path) -> None:
    """Motion is what stands out of its own noise, however small it is."""
    names, _, values = columns(motion())
    units, rng = ["s", "m", "m", "N", "N"], np.random.default_rng(1)
    for size, groups in ((5e-6, 1), (0.0, 2)):
        logs = []
        for k in range(2):
            noise = rng.standard_normal(values.shape)
            run = values * [1.0, size, size, 1.0, 1.0] + noise * [0.0, 1e-9, 1e-9, 0.01, 0.01]
            logs.append(read_log(write_csv(tmp_path / f"{k}.csv", names, units, run)))
        assert len(group_runs(logs)) == groups


def test_trajectory_keeps_its_kinds(tmp_path: Path) -> None:
    r = np.stack([np.linspace(0, 1, 50), np.linspace(0, 0.2, 50)], axis=1)
    path = write_trajectory(Trajectory("t", 1e-3, r, kinds=(ROTARY, LINEAR)), tmp_path / "t.csv")
    assert path.read_text().splitlines()[1] == "s,rad,m"
    assert read_trajectory(path).kinds == (ROTARY, LINEAR)


def test_units_of_the_library_have_a_linear_form() -> None:
    """Every unit that an effect has becomes one without turns, and says how it scales."""
    units = {"kg m2": "kg", "N m s/rad": "N s/m", "1/N2 m2": "1/N2", "rad/s2": "m/s2", "Hz": "Hz"}
    assert {unit: LINEAR.unit(unit) for unit in units} == units
    assert [powers(u) for u in ("kg m2", "N m/rad2", "1/N m", "1/rad", "N m s/rad", "s")] == [
        (1, -1),
        (1, -2),
        (-1, 0),
        (0, -1),
        (1, -1),
        (0, 0),
    ]
    for effect in library().values():
        for par in (*effect.gains, *effect.shapes):
            assert ROTARY.unit(par.unit) == par.unit
            own = LINEAR.unit(par.unit)
            assert "rad" not in own
            assert "N m" not in own
            assert "kg m" not in own

"""Data of motors: read in any of the units that they come in, refused where they are none; torques
from voltages by a solver of another kind."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from flexhex import UsageError, read_log
from flexhex.diagnosis.kinds import IN_VOLTS, LINEAR, ROTARY
from flexhex.diagnosis.logs.motor import motor_of
from flexhex.fmus.common.errors import LogError
from tests.diagnosis.logs.test_faults import finding
from tests.diagnosis.synthetic import write_csv

Array = NDArray[np.float64]
TS, R, K, L, GEAR = 1e-3, 1.2, 0.05, 3.6e-3, 20.0
CLOCK = np.arange(2000) * TS
TOLERANCE = 5e-4
"""Of a torque of 4 N m: 1e-3 of the first current is not forgotten when the first sample counts."""


def logged(
    path: Path,
    units: tuple[str, str] = ("rad", "V"),
    names: tuple[str, str] = ("theta", "tau_meas"),
    meta: Mapping[str, str] | None = None,
    gap: slice = slice(0),
) -> Path:
    """A log of two axes, of which the second goes twice as far."""
    theta = np.sin(5 * CLOCK)
    volts = 3 * np.sin(12 * CLOCK) + 1
    values = np.column_stack([CLOCK, theta, 2 * theta, volts, 2 * volts])
    values[gap, 3:] = np.nan
    named = [f"{name}[{k}]" for name in names for k in (1, 2)]
    each = [unit for unit in units for _ in range(2)]
    return write_csv(path, ["time", *named], ["s", *each], values, dict(meta or {}))


def current(lag: float) -> Array:
    """Current (samples,) [A] of the first axis by a solver; without a lag algebraically."""

    def pushed(t: float | Array) -> Array:
        return np.asarray(3 * np.sin(12 * t) + 1 - K * GEAR * 5 * np.cos(5 * t)) / R

    if not lag:
        return pushed(CLOCK)

    def rate(t: float, i: Array) -> Array:
        return np.asarray((pushed(t) - i) / lag)

    solved = solve_ivp(rate, (0, CLOCK[-1]), [0.0], "RK45", CLOCK, rtol=1e-9, atol=1e-10)
    return np.asarray(solved.y[0])


@pytest.mark.parametrize("inductance", [0.0, L])
def test_torque_is_that_of_the_differential_equation(inductance: float, tmp_path: Path) -> None:
    """Also where the run begins: by then an unknown first current is forgotten."""
    path = logged(tmp_path / "a.csv")
    log = read_log(path, motor={"R": R, "K_t": K, "L": inductance, "gear": GEAR})
    valid = log["tau_meas"].valid
    assert valid.sum() > 1970
    expected = GEAR * K * current(inductance / R)
    assert log.tau[valid, 0] == pytest.approx(expected[valid], abs=TOLERANCE * 4)
    assert log.tau[valid, 1] == pytest.approx(2 * expected[valid], abs=TOLERANCE * 8)
    assert log.kinds == (ROTARY, ROTARY)


def test_each_axis_has_its_own_motor(tmp_path: Path) -> None:
    """Angles and voltages of the second are twice those of the first."""
    path = logged(tmp_path / "a.csv")
    log = read_log(path, motor=f"R={R},{4 * R} K_t={K} gear={GEAR},{-GEAR} gain=1,-1")
    inner = log["tau_meas"].valid
    expected = GEAR * K * current(0.0)
    assert log.tau[inner, 0] == pytest.approx(expected[inner], abs=4 * TOLERANCE)
    # gear and gain negative: its motor is mounted the other way round
    assert log.tau[inner, 1] == pytest.approx(expected[inner] / 2, abs=4 * TOLERANCE)


def test_samples_behind_a_gap_are_used_once_the_current_has_forgotten_it(tmp_path: Path) -> None:
    path = logged(tmp_path / "a.csv", gap=slice(900, 950))
    log = read_log(path, motor=f"R={R} K_t={K} L={L} gear={GEAR}")
    valid, expected = log["tau_meas"].valid, GEAR * K * current(L / R)
    # seven time constants of 3 ms
    assert not valid[900:971].any()
    assert valid[975:].sum() > 1000
    error = np.abs(log.tau[:, 0] - expected)
    assert error[valid].max() < 4 * TOLERANCE
    assert error[950] > 20 * TOLERANCE


def test_measured_rates_are_taken_where_they_are_better(tmp_path: Path) -> None:
    theta = np.round(np.sin(5 * CLOCK), 4)
    rate = 5 * np.cos(5 * CLOCK)
    path = write_csv(
        tmp_path / "a.csv",
        ["time", "theta[1]", "thetad[1]", "tau_meas[1]"],
        ["s", "rad", "rad/s", "V"],
        np.column_stack([CLOCK, theta, rate, np.zeros_like(rate)]),
    )
    log = read_log(path, motor=f"R={R} K_t={K}")
    inner = log["tau_meas"].valid
    # differences of these angles are off by 0.1 rad/s
    assert log.tau[inner, 0] == pytest.approx(-(K**2) / R * rate[inner], abs=1e-9)
    assert "which are thetad" in finding(log, "units").text


@pytest.mark.parametrize(
    ("written", "name", "value"),
    [
        ("R=1.2 ohm K_t=50 mN m/A", "K_t", 0.05),
        ("R=1.2, K_t=0.05; L=0.5 mH", "L", 5e-4),
        ("R=1.2 K_t=0.05 K_e=5.236 V/krpm", "K_e", 0.05),
        ("R=1.2 K_t=0.05", "K_e", 0.05),
        ("R=1.2Ω K_t=.05 gear=-1e2", "gear", -100.0),
        ({"R": 1.2, "K_t": np.float64(0.05), "gain": -1}, "gain", -1.0),
    ],
)
def test_entries_are_read_in_their_units(
    written: str | dict[str, object], name: str, value: float
) -> None:
    assert getattr(motor_of(written), name) == pytest.approx((value,), rel=1e-4)


@pytest.mark.parametrize(
    ("written", "why"),
    [
        ("R=0 K_t=1", r"R is 0: it must be above zero"),
        ("R=-1.2 K_t=1", r"R is -1\.2: it must be above zero"),
        ("R=nan K_t=1", r"R is nan"),
        ("R=inf K_t=1", r"R is inf"),
        ("R=1.2 K_t=1 L=-1", r"L is -1: it must be not below zero"),
        ("R=1.2 K_t=1 gear=0", r"gear is 0: it must be other than zero"),
        ("R=1.2", r"K_t missing: write for instance 'R=1\.2 K_t=0\.05'"),
        ("", r"write for instance"),
        ("1.2 ohm", r"write for instance"),
        ("R=1.2 Kt=1", r"no entry 'Kt': did you mean K_t\?"),
        ("R=1.2 K_t=0.05 Nm/V", r"K_t is in 'Nm/V': units known here are Nm/A"),
        ("R=1.2 K_t=x", r"K_t=x: wanted a number"),
        ("R=1.2 R=3 K_t=1", r"R stands there twice"),
        ({"R": True, "K_t": 1.0}, r"R is True: wanted a number"),
        ({"R": [], "K_t": 1.0}, r"R has no number"),
        (3, r"must be a text, 'R=1\.2 K_t=0\.05', or a dictionary"),
    ],
)
def test_what_is_no_motor_is_refused(written: object, why: str, tmp_path: Path) -> None:
    path = logged(tmp_path / "a.csv")
    with pytest.raises(UsageError, match=f"^motor.*{why}"):
        read_log(path, motor=written)  # type: ignore[arg-type]
    if isinstance(written, str) and written:
        head = logged(tmp_path / "b.csv", meta={"motor": written})
        with pytest.raises(LogError, match=rf"b\.csv: motor: .*{why}"):
            read_log(head)


@pytest.mark.parametrize(
    ("units", "motor", "why"),
    [
        (("rad", "V"), "R=1,2,3 K_t=0.05", r"R has 3 numbers for 2 axes"),
        (("rad", "V"), "R=1 K_t=3 N/A", r"axis 1 turns"),
        (("m", "V"), "R=1 K_t=3 Nm/A", r"axis 1 is linear .* give gear="),
        (("rad", "V"), "R=1 K_t=3 gear=3 rad/m", r"gear is that of a linear axis"),
        (("m", "V"), "R=1 K_t=3 N/A K_e=3 V s/rad", r"units of different motors"),
        (("rad", "V"), "R=1.2 K_t=0.05 L=3.6", r"L/R is 3 s"),
        (("rad", "N m"), "R=1 K_t=3", r"motor data are for logs in V, but tau_meas is a torque"),
    ],
)
def test_motor_of_another_axis_is_refused(
    units: tuple[str, str], motor: str, why: str, tmp_path: Path
) -> None:
    path = logged(tmp_path / "a.csv", units)
    with pytest.raises(LogError, match=rf"a\.csv: .*{why}"):
        read_log(path, motor=motor)


def test_motor_and_torque_constant_are_not_both_given(tmp_path: Path) -> None:
    both = {"motor": "R=1 K_t=1", "torque_constant": "3 N m/V"}
    path = logged(tmp_path / "a.csv", meta=both)
    with pytest.raises(LogError, match="both `motor` and `torque_constant`"):
        read_log(path)
    with pytest.raises(UsageError, match="motor: not beside torque_constant"):
        read_log(path, motor="R=1 K_t=1", torque_constant=3.0)
    # either option outweighs the head
    assert "torque constant 2 N m/V" in finding(read_log(path, torque_constant=2.0), "units").text
    assert "motor data R=2 K_t=1" in finding(read_log(path, motor="R=2 K_t=1"), "units").text


def test_constants_that_are_far_apart_are_said(tmp_path: Path) -> None:
    log = read_log(logged(tmp_path / "a.csv"), motor="R=1.2 K_t=0.05 K_e=5.2")
    assert any("K_e and K_t" in f.text and not f.corrected for f in log.findings)


def test_voltage_beside_a_torque_is_not_used(tmp_path: Path) -> None:
    path = logged(tmp_path / "a.csv", names=("theta", "voltage"))
    log = read_log(path)
    assert log.kinds == (IN_VOLTS[ROTARY],) * 2
    text = path.read_text().replace("voltage[2]", "tau_meas[1]").replace("theta[2]", "r[1]")
    path.write_text(text.replace("s,rad,rad,V,V", "s,rad,rad,V,N m"))
    log = read_log(path)
    assert log.tau[:, 0] == pytest.approx(6 * np.sin(12 * CLOCK) + 2, abs=1e-6)
    assert log.kinds == (ROTARY,)
    assert "voltage: not used, as there is tau_meas" in finding(log, "extra").text


def test_command_in_volts_is_not_compared_with_a_torque(tmp_path: Path) -> None:
    path = logged(tmp_path / "a.csv", units=("m", "N"))
    text = path.read_text().replace("tau_meas[2]", "tau[1]").replace("theta[2]", "r[1]")
    path.write_text(text.replace("s,m,m,N,N", "s,m,m,N,V"))
    log = read_log(path)
    assert "tau" not in log.channels
    assert log.kinds == (LINEAR,)
    assert "tau: in V, as tau_meas is not: not used" in finding(log, "units").text

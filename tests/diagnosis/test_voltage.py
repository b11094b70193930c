"""Axes whose logs hold the voltage of a DC motor: its friction, in N m where the motor is known, in
volts where it is not."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path
from tempfile import mkdtemp

import pytest

from flexhex.diagnosis.estimation.identified import identify
from flexhex.diagnosis.logs import Options as Reading
from flexhex.diagnosis.logs.motor import motor_of
from flexhex.diagnosis.result.verdict import Diagnosis
from flexhex.diagnosis.workflow import Options, diagnose
from flexhex.fmus.common.errors import LogError
from tests.diagnosis.motors import COGGING, F_C, GEAR, ORDER, D, J, K, L, R, write

several = pytest.mark.sample(3, of="axes in volts")

MOTOR = f"R={R} K_t={K} L={L} gear={GEAR:g}"
RUBBED = {"coulomb_friction", "cogging_harmonic"}
LATE = {"drive_lag", "time_delay"}
ABSOLUTE = re.compile(r"\bN\b|\bNm\b|\bkg\b")


def options(motor: str = "") -> Options:
    """Those of axes with this motor, or an unknown one."""
    return Options("axis", Reading(motor=motor_of(motor) if motor else None))


@cache
def said(motor: str, rubbed: float = 1.0) -> Diagnosis:
    """The answer for an axis with this share of its friction and cogging."""
    *fit, other = write(Path(mkdtemp()) / "runs", rubbed=rubbed)
    return diagnose(fit, [other], options=options(motor))


def found(diagnosis: Diagnosis) -> dict[str, tuple[float, float]]:
    """The interval of each parameter of effects and base model."""
    of_effects = {k: v for e in diagnosis.effects for k, v in e.parameters.items()}
    return {
        **{name: one.ci95 for name, one in of_effects.items()},
        **{one.name: one.estimate.ci95 for one in diagnosis.parameters},
    }


def assert_holds(diagnosis: Diagnosis, truth: dict[str, float]) -> None:
    """Each interval holds the truth and is no wider than a fifth of it."""
    intervals = found(diagnosis)
    for name, true in truth.items():
        low, high = intervals[name]
        assert low < true < high, name
        assert high - low < 0.2 * true, name


@several
def test_friction_of_a_known_motor_is_found_in_newton_metres() -> None:
    """Neither its back-EMF nor its electrical pole of 3 ms is left to be a damping or a lag."""
    diagnosis = said(MOTOR)
    assert diagnosis.verdict == "named"
    assert {effect.id for effect in diagnosis.effects} == RUBBED
    assert not [text for text in diagnosis.findings if "lags" in text or "leads" in text]
    assert_holds(diagnosis, {"F_c": F_C, "a": COGGING, "order": ORDER, "J[1]": J, "d[1]": D})
    assert diagnosis.residual.unit == "N m"


@several
def test_axis_of_a_known_motor_without_friction_has_nothing() -> None:
    diagnosis = said(MOTOR, 0.0)
    assert diagnosis.verdict == "none"
    assert_holds(diagnosis, {"J[1]": J, "d[1]": D})


@several
def test_same_effects_are_found_in_volts_of_an_unknown_motor() -> None:
    """Its pole is there, too, as the lag that it is; back-EMF is in the viscous friction."""
    diagnosis, per_volt = said(""), GEAR * K / R
    named = {effect.id for effect in diagnosis.effects}
    assert RUBBED <= named <= RUBBED | LATE
    volts = {"F_c": F_C, "a": COGGING, "d[1]": D + GEAR**2 * K**2 / R}
    assert_holds(diagnosis, {name: value / per_volt for name, value in volts.items()})


@several
def test_no_output_of_an_unknown_motor_has_an_absolute_unit(tmp_path: Path) -> None:
    diagnosis = said("")
    (said_once,) = [text for text in diagnosis.findings if "relative, in volts" in text]
    assert "back-EMF" in said_once
    assert "--motor" in said_once
    units = {one.name: one.estimate.unit for one in diagnosis.parameters}
    assert units["J[1]"] == "V s2/rad"
    assert units["d[1]"] == "V s/rad"
    assert diagnosis.residual.units == ("V",)
    texts = [*diagnosis.notes, *diagnosis.findings, str(diagnosis.data())]
    fitted = identify(write(tmp_path / "runs"), options=options())
    assert {one.estimate.unit for one in fitted.parameters} >= {"V", "V s2/rad", "V s/rad"}
    texts += [str(fitted.data()), *fitted.notes, *fitted.findings]
    drawn = {unit for m in diagnosis.maps for unit in (m.unit, m.residual)}
    texts += [*drawn, *(strip.unit for strip in diagnosis.strips)]
    assert not [text for text in texts if ABSOLUTE.search(text)]


def test_resistance_off_by_a_tenth_scales_all_and_shows_nowhere(tmp_path: Path) -> None:
    """All torques are a tenth smaller, and as much of them is left."""
    paths = write(tmp_path / "runs")
    right, wrong = (
        identify(paths, options=options(f"R={scale * R} K_t={K} L={scale * L} gear={GEAR:g}"))
        for scale in (1.0, 1.1)
    )
    values = [{one.name: one.estimate.value for one in of.parameters} for of in (right, wrong)]
    for name in ("J[1]", "d[1]", "F_c[1]"):
        assert values[1][name] == pytest.approx(values[0][name] / 1.1, rel=1e-3)
    assert wrong.errors.fitted == pytest.approx(right.errors.fitted, rel=1e-2)


def test_head_channel_gain_and_counts_are_the_same_as_the_option(tmp_path: Path) -> None:
    """Counts of 3276.7 to a volt, at an amplifier of 2.5 V/V, with the motor in the head."""
    plain = identify(write(tmp_path / "plain"), options=options(MOTOR))
    head = f"motor: R={R} ohm, K_t={1e3 * K} mNm/A, L={1e3 * L} mH; gear={GEAR:g} gain=2.5"
    counted = write(
        tmp_path / "counts", [head], channel=("voltage", "V/3276.7"), divided=2.5 / 3276.7
    )
    other = identify(counted, options=options())
    values = [[one.estimate.value for one in of.parameters] for of in (plain, other)]
    assert values[1] == pytest.approx(values[0], rel=1e-4, abs=1e-6)


def test_screw_makes_newtons_of_a_motor_that_turns(tmp_path: Path) -> None:
    """Of 5 mm/rad behind the gear: force is torque over that, mass is inertia over its square."""
    lead = 0.005
    paths = write(tmp_path / "runs", way=(1e3 * lead, "mm"))
    fitted = identify(paths, options=options(f"R={R} K_t={K} Nm/A L={L} gear={GEAR / lead} rad/m"))
    values = {one.name: one.estimate for one in fitted.parameters}
    assert values["m[1]"].unit == "kg"
    assert values["m[1]"].value == pytest.approx(J / lead**2, rel=0.02)
    assert values["F_c[1]"].value == pytest.approx(F_C / lead, rel=0.05)
    relative = {
        one.name: one.estimate.unit for one in identify(paths, options=options()).parameters
    }
    assert (relative["m[1]"], relative["d[1]"], relative["F_c[1]"]) == ("V s2/m", "V s/m", "V")


def test_log_in_volts_is_refused_beside_one_in_newton_metres(tmp_path: Path) -> None:
    volts, *_ = write(tmp_path / "volts")
    other = write(tmp_path / "torques", channel=("tau_meas", "N m"))[2]
    with pytest.raises(LogError, match=r"2-1\.csv: axis 1 is rotary .*--motor 'R=1\.2 K_t"):
        diagnose([volts, other], options=options())
    with pytest.raises(LogError, match=r"2-1\.csv: motor data are for logs in V"):
        diagnose([other], options=options(MOTOR))


def test_payload_of_some_runs_is_found_in_volts(tmp_path: Path) -> None:
    """More inertia in the second pass of each motion, which no head announces."""
    more = 0.06
    fitted = identify(write(tmp_path / "runs", rubbed=0.0, heavy=more)[:4], options=options())
    payload = next(one.estimate for one in fitted.parameters if one.name == "payload.J[1]")
    assert payload.unit == "V s2/rad"
    assert payload.value == pytest.approx(more * R / (GEAR * K), rel=0.01)
    (text,) = [note for note in fitted.notes if "more than the other runs" in note]
    assert "V s2/rad" in text


def test_own_base_with_masses_refuses_volts(tmp_path: Path) -> None:
    """Also one that takes its axes from the log."""
    own = tmp_path / "own.py"
    own.write_text(
        "class Arm:\n    parameters = [('J', 'kg m2')]\n"
        "    def columns(self, theta, thetad, thetadd):\n        return thetadd[:, :, None]\n"
    )
    path, *_ = write(tmp_path / "runs")
    base = Options(f"{own}:Arm")
    with pytest.raises(LogError, match=r"1-1\.csv: axis 1 is rotary in volts .*--motor"):
        identify([path], options=base)
    known = Options(base.base, options(MOTOR).log)
    assert identify([path], options=known).parameters[0].estimate.unit == "kg m2"

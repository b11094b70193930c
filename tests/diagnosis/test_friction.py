"""Friction in other forms than the library's: sharper, lopsided, with a peak when slow."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.result.verdict import Diagnosis
from flexhex.diagnosis.workflow import Options, diagnose
from tests.diagnosis.single import SECONDS, TS, moved, wanted, write

Array = NDArray[np.float64]
several = pytest.mark.sample(3, of="forms of friction")
OPTIONS = Options(base="axis")
RUNS = ((1, 1), (1, 2), (2, 1), (2, 2), (3, 1), (3, 2))
"""Motion and pass; the last motion is judged on."""
CLOCK = np.arange(round(SECONDS / TS)) * TS
F = 0.015
"""3 % of the torque [N m]."""


def said(folder: Path, friction: Callable[[Array], Array], steps: float = 1e-6) -> Diagnosis:
    """The answer for a friction torque [N m] that depends on the rate [rad/s]; steps [rad] of the
    encoder."""
    paths = []
    for k, (motion, number) in enumerate(RUNS):
        _, rate, _ = moved(CLOCK, motion)
        path = folder / f"{k}.csv"
        paths.append(write(path, motion, number, 0.0, extra=friction(rate), steps=steps))
    return diagnose(paths[:4], paths[4:], options=OPTIONS)


@several
def test_sharp_friction_leaves_nothing(tmp_path: Path) -> None:
    """It turns over within less than a sample: no angle of presliding is to be seen."""
    diagnosis = said(tmp_path, lambda rate: F * np.tanh(rate / 0.002))
    (effect,) = diagnosis.effects
    assert effect.id == "coulomb_friction"
    assert effect.parameters["F_c"].value == pytest.approx(F, rel=0.03)
    after, non_repeatable = (
        float(diagnosis.residual.held_out[name][0]) for name in ("after", "non_repeatable")
    )
    assert after < 1.1 * non_repeatable


@several
def test_friction_of_a_gear_grows_with_its_load(tmp_path: Path) -> None:
    """Teeth that lose 3 % of the torque, beside bearings that lose always the same: two effects."""
    paths = []
    for k, (motion, number) in enumerate(RUNS):
        _, rate, _ = moved(CLOCK, motion)
        lost = (F + 0.03 * np.abs(wanted(CLOCK, motion))) * np.tanh(rate / 0.01)
        paths.append(write(tmp_path / f"{k}.csv", motion, number, 0.0, extra=lost))
    diagnosis = diagnose(paths[:4], paths[4:], options=OPTIONS)
    first, second = sorted(diagnosis.effects, key=lambda effect: effect.id)
    assert (first.id, second.id) == ("coulomb_friction", "load_friction")
    assert first.parameters["F_c"].value == pytest.approx(F, rel=0.1)
    assert second.parameters["mu"].value == pytest.approx(0.03, rel=0.1)
    assert not (*first.rivals, *second.rivals)


@several
def test_lopsided_friction_is_one_friction(tmp_path: Path) -> None:
    """A second one beside it, of the other sign, would follow what is left of it."""

    def lopsided(rate: Array) -> Array:
        return F * np.tanh(rate / 0.01) * np.where(rate > 0, 1.3, 0.7)

    (effect,) = said(tmp_path, lopsided).effects
    assert effect.id == "coulomb_friction"
    assert effect.parameters["F_c"].value == pytest.approx(F, rel=0.05)


@several
def test_peak_of_slow_motion_is_found_with_its_rate(tmp_path: Path) -> None:
    diagnosis = said(tmp_path, lambda rate: F * np.sign(rate) * (1 + np.exp(-((rate / 0.2) ** 2))))
    (effect,) = diagnosis.effects
    assert effect.id == "stribeck_friction"
    values = {name: estimate.value for name, estimate in effect.parameters.items()}
    assert values["F_c"] == pytest.approx(F, rel=0.05)
    assert values["F_s"] == pytest.approx(F, rel=0.2)
    assert values["v_s"] == pytest.approx(0.2, rel=0.2)


@several
def test_noise_of_the_angles_is_no_way_that_friction_forgets(tmp_path: Path) -> None:
    """10 microradians of noise go 10 mrad in a second; Stribeck's law seemed the better for it."""
    (effect,) = said(tmp_path, lambda rate: F * np.tanh(rate / 0.002), steps=5e-6).effects
    assert effect.id == "coulomb_friction"
    assert effect.parameters["F_c"].value == pytest.approx(F, rel=0.05)

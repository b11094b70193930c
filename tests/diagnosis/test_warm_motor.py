"""A motor warms up by all the torque that its drive reports: that of friction, and its own loss."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.estimation.extras import Extra, Extras
from flexhex.diagnosis.estimation.identified import identify
from flexhex.diagnosis.workflow import Options, diagnose
from flexhex.fmus.common.effects import library
from tests.diagnosis.synthetic import plain_csv

Array = NDArray[np.float64]
TS, NOISE = 2e-3, 0.08
COULOMB, WITHIN = 0.6, 0.01
LOSS, WARM = 0.003, 9.0
MOTIONS = ((0.9, 1.3, 0.25, 4.1), (0.7, 0.8, 0.3, 3.2))
"""Amplitudes [rad] and rates [rad/s] of two waves."""


def needed(t: Array, a: float, v: float, b: float, w: float) -> tuple[Array, Array, Array]:
    """Angle, torque without friction, and direction of friction."""
    angle = a * np.sin(v * t) + b * np.sin(w * t + 1) + 0.5
    rate = a * v * np.cos(v * t) + b * w * np.cos(w * t + 1)
    acceleration = -a * v**2 * np.sin(v * t) - b * w**2 * np.sin(w * t + 1)
    torque = 0.4 * acceleration + 0.5 * rate + 9.0 * np.sin(angle)
    return angle, torque, np.tanh(rate / WITHIN)


def warming(torque: Array, turned: Array) -> Array:
    """What a drive reports whose magnets lose LOSS times the mean square of that."""
    joint, reported, heat = torque + COULOMB * turned, np.empty_like(torque), 0.0
    for k, wanted in enumerate(joint):
        reported[k] = wanted / (1 - LOSS * heat)
        heat += (reported[k] ** 2 - heat) * TS / WARM
    return reported


@pytest.fixture
def logs(tmp_path: Path) -> list[Path]:
    """Two passes of each motion."""
    paths, t, rng = list[Path](), np.arange(0.0, 25.0, TS), np.random.default_rng(7)
    for motion, waves in enumerate(MOTIONS):
        for number in (1, 2):
            angle, torque, turned = needed(t, *waves)
            tau = warming(torque, turned) + NOISE * rng.standard_normal(len(t))
            run = {"time": t, "theta": angle[:, None], "tau_meas": tau[:, None]}
            head = {"trajectory": str(motion), "pass": str(number)}
            paths.append(plain_csv(tmp_path / f"{motion}{number}.csv", run, **head))
    return paths


def test_diagnosis_finds_the_loss_and_the_friction(logs: list[Path]) -> None:
    found = diagnose(logs, options=Options(base="axis"))
    values = {f"{e.id}.{n}": v.value for e in found.effects for n, v in e.parameters.items()}
    assert values["thermal_drift.g_w"] == pytest.approx(LOSS, rel=0.03)
    assert values["thermal_drift.T"] == pytest.approx(WARM, rel=0.05)
    assert values["coulomb_friction.F_c"] == pytest.approx(COULOMB, rel=0.02)


def test_identification_has_them_in_its_intervals(logs: list[Path]) -> None:
    """From a loss that is a third too large on."""
    drift = library()["thermal_drift"]
    warm = Extra(drift, 0, {"T": 1.2 * WARM}, 1, (0.0, 1.3 * LOSS), {"T": 1.0})
    identified = identify(logs, options=Options(base="axis"), more=Extras((warm,)))
    found = {known.terms[0][0]: known.estimate for known in identified.parameters}
    wanted = {"thermal_drift.g_w[1]": LOSS, "thermal_drift.T[1]": WARM, "F_c[1]": COULOMB}
    for name, value in wanted.items():
        low, high = found[name].ci95
        assert low < value < high, name
        assert high - low < 0.1 * value

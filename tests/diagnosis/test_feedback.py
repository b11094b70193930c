"""Noise of an encoder moves its axis, by feedback: where nothing is run twice, it has no name."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.signal import lfilter

from flexhex.diagnosis.result.verdict import Diagnosis
from flexhex.diagnosis.workflow import Options, diagnose
from tests.diagnosis.single import SECONDS, TS, J, moved
from tests.diagnosis.synthetic import plain_csv

AXIS = Options(base="axis")
BANDWIDTH, NOISE, CREEP = 60.0, 2e-5, 0.01
"""Of the feedback w [rad/s]; RMS noise of the angles [rad]; rate within which friction turns
[rad/s]."""


def closed_loop(folder: Path, seed: int, friction: float) -> Path:
    """A run of J q'' + friction(q') = u under feedback, with an exact feedforward of its motion r.

    With (s + w)^2 as the characteristic polynomial and v the noise, q = r - a v with
    a = (2 w s + w^2) / (s + w)^2 = 2 / (s/w + 1) - 1 / (s/w + 1)^2.
    """
    t = np.arange(round(SECONDS / TS)) * TS
    r, rate, acceleration = moved(t, seed)
    noise = NOISE * np.random.default_rng(seed).standard_normal(len(t))
    kept = np.exp(-BANDWIDTH * TS)
    lagged = lfilter([1 - kept], [1, -kept], noise)
    answer = 2 * lagged - lfilter([1 - kept], [1, -kept], lagged)
    torque = J * (acceleration - np.gradient(np.gradient(answer, TS), TS))
    torque += friction * np.tanh(rate / CREEP)
    run = {"time": t, "theta": (r - answer + noise)[:, None], "tau_meas": torque[:, None]}
    return plain_csv(folder / f"{seed}.csv", run, trajectory=str(seed))


def answer(folder: Path, friction: float) -> Diagnosis:
    """Of three motions, each run once."""
    return diagnose([closed_loop(folder, seed, friction) for seed in (1, 2, 3)], options=AXIS)


def test_answer_to_noise_has_no_name(tmp_path: Path) -> None:
    diagnosis = answer(tmp_path, 0.0)
    assert (diagnosis.verdict, diagnosis.effects) == ("cannot tell", ())
    assert not any("explained by no effect" in note for note in diagnosis.notes)


def test_effect_is_named_beside_the_answer_to_noise(tmp_path: Path) -> None:
    (effect,) = answer(tmp_path, 0.02).effects
    assert effect.id == "coulomb_friction"
    assert effect.parameters["F_c"].value == pytest.approx(0.02, rel=0.05)

"""Noise and steps of the angles: what they would make of a hysteresis, and how long to smooth."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.motion import dahl_states
from flexhex.diagnosis.play import REACH, angle_noise, encoder_step, play
from flexhex.diagnosis.window import curvature

Array = NDArray[np.float64]
TS, SIGMA = 1e-3, 0.015


def motion(seconds: float = 20.0) -> Array:
    """Two axes that move for two seconds, then stand (samples, 2) [rad]."""
    t = np.minimum(np.arange(0.0, seconds, TS), 2.0)
    return np.stack([0.1 * np.sin(np.pi * t / 4), 0.05 * (1 - np.cos(np.pi * t / 2))], axis=1)


def noisy(deviation: float) -> Array:
    clean = motion()
    return clean + deviation * np.random.default_rng(3).standard_normal(clean.shape)


def test_noise_makes_a_dahl_state_forget_and_play_keeps_it() -> None:
    clean, seen = motion(), noisy(2e-6)
    wanted = dahl_states(clean, SIGMA)[-1]
    forgot = dahl_states(seen, SIGMA)[-1]
    kept = dahl_states(play(seen, REACH * angle_noise(seen)), SIGMA)[-1]
    assert (np.abs(forgot) < 0.5 * np.abs(wanted)).all(), "the case must be one that forgets"
    # the gap's way: 2 * 8 urad of 15 mrad
    assert kept == pytest.approx(wanted, abs=3e-3)


def test_play_is_exact_where_there_is_no_noise() -> None:
    clean = motion()
    assert np.array_equal(play(clean, np.zeros(2)), clean)


def test_play_follows_behind_its_gap() -> None:
    there_and_back = np.array([[0.0], [1.0], [0.9], [0.5], [0.6]])
    assert play(there_and_back, np.array([0.2])).ravel() == pytest.approx([0, 0.8, 0.8, 0.7, 0.7])


@pytest.mark.parametrize("deviation", [1e-7, 2e-6, 3e-5])
def test_noise_of_angles_is_measured_though_they_move(deviation: float) -> None:
    # 20 000 samples, a twentieth left out at the top: 10 % low at most
    assert angle_noise(noisy(deviation)) == pytest.approx([deviation] * 2, rel=0.15)


def test_clean_angles_have_no_noise_to_speak_of() -> None:
    assert (angle_noise(motion()) < 1e-9).all()


def test_step_of_an_encoder_is_found_through_an_offset_and_bridged_samples() -> None:
    step = 2 * np.pi / 2**18
    angles = step * np.round(noisy(1e-6) / step) + 0.3
    angles[500:504] += np.linspace(0, step / 3, 4)[:, None]
    assert encoder_step(angles) == pytest.approx([step] * 2, rel=1e-6)
    assert angle_noise(angles).min() >= 0.999 * step / np.sqrt(12)


def test_angles_without_steps_have_none() -> None:
    assert encoder_step(noisy(2e-6)) == pytest.approx([0.0, 0.0])


def test_curvature_is_that_of_the_hann_window() -> None:
    window = 0.02
    t = np.arange(-window / 2, window / 2 + TS / 2, TS)
    weights = np.cos(np.pi * t / window) ** 2
    by_hand = np.linalg.norm(np.diff(np.pad(weights / weights.sum(), 2), 2)) / TS**2
    # sums instead of integrals over twenty samples
    assert curvature(window, TS) == pytest.approx(by_hand, rel=0.05)

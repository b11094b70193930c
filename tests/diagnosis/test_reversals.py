"""Noise and steps of the angles: what they would make of a hysteresis, and how long to smooth."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.estimation.motion import dahl_states
from flexhex.diagnosis.regression.window import curvature
from flexhex.diagnosis.reversals import (
    REACH,
    _reversals,
    angle_noise,
    encoder_step,
    hysteresis_filter,
    turning,
)

Array = NDArray[np.float64]
TS, SIGMA = 1e-3, 0.015


def motion(seconds: float = 20.0) -> Array:
    """Two axes that move for two seconds, then stand (samples, 2) [rad]."""
    t = np.minimum(np.arange(0.0, seconds, TS), 2.0)
    return np.stack([0.1 * np.sin(np.pi * t / 4), 0.05 * (1 - np.cos(np.pi * t / 2))], axis=1)


def noisy(deviation: float) -> Array:
    clean = motion()
    return clean + deviation * np.random.default_rng(3).standard_normal(clean.shape)


def test_noise_makes_a_dahl_state_forget_and_the_filter_keeps_it() -> None:
    clean, seen = motion(), noisy(2e-6)
    wanted = dahl_states(clean, SIGMA)[-1]
    forgot = dahl_states(seen, SIGMA)[-1]
    kept = dahl_states(hysteresis_filter(seen, angle_noise(seen)), SIGMA)[-1]
    assert (np.abs(forgot) < 0.5 * np.abs(wanted)).all(), "the case must be one that forgets"
    # noise goes on by some 8 urad of 15 mrad
    assert kept == pytest.approx(wanted, abs=3e-3)


def test_angles_without_noise_stay_as_they_are() -> None:
    clean = motion()
    assert np.array_equal(hysteresis_filter(clean, np.zeros(2)), clean)


def test_angles_turn_where_they_go_back_by_more_than_the_noise() -> None:
    there_and_back = np.array([[0.0], [1.0], [0.9], [0.95], [0.5], [0.6], [0.4], [0.45]])
    wanted = [0.0, 1.0, 0.9, 0.9, 0.5, 0.5, 0.4, 0.4]
    assert hysteresis_filter(there_and_back, np.array([0.02])).ravel().tolist() == wanted


def test_an_encoder_turns_in_the_middle_of_its_last_step() -> None:
    steps = np.array([0.0, 1.0, 2.0, 2.0, 2.0, 2.0, 2.0, 1.0, 0.0])[:, None]
    noise = np.array([1 / np.sqrt(12)])
    assert (_turns(steps, 0.0), _turns(10 * steps, noise[0])) == ([6], [4])
    assert np.abs(hysteresis_filter(10 * steps, noise) - 10 * steps).max() < 0.3


def test_turns_are_placed_between_samples() -> None:
    step, pace = 0.05, 2 * np.pi / 2.17
    t = np.arange(0.0, 40.0, step)
    angle = 0.1 * np.sin(pace * t)[:, None]
    lateness = turning(angle, np.zeros(1))[:, 0]
    true = np.arange(0.5, t[-1] * pace / np.pi, 1.0) * np.pi / pace / step
    places = np.flatnonzero(lateness)
    assert len(places) == len(true)
    np.testing.assert_allclose(places + lateness[places], true, atol=0.01)
    steps = np.array([0.0, 1.0, 2.0, 2.0, 1.0, 0.0])[:, None]
    assert turning(steps, np.array([0.05])).ravel().tolist() == [0.0, 0.0, 0.5, 0.0, 0.0, 0.0]


@pytest.mark.parametrize("deviation", [1e-5, 1e-4])
def test_reversals_in_noise_are_not_late(deviation: float) -> None:
    t = np.arange(0.0, 200.0, TS)
    clean = 0.1 * np.sin(2 * np.pi * t / 2.0)[:, None]
    seen = clean + deviation * np.random.default_rng(4).standard_normal(clean.shape)
    turns = _turns(seen, deviation)
    true = np.arange(500, len(t), 1000)
    assert len(turns) == len(true)
    # a play operator would be late by the square root of gap over curvature
    late = np.sqrt(2 * REACH * deviation / (0.1 * np.pi**2)) / TS
    assert abs(np.mean(turns - true)) < 0.1 * late


def _turns(angles: Array, noise: float) -> list[int]:
    """Samples from which the filtered angle goes the other way."""
    steps = np.sign(np.diff(hysteresis_filter(angles, np.array([noise]))[:, 0]))
    moves = np.flatnonzero(steps)
    return [int(b) for a, b in pairwise(moves) if steps[a] != steps[b]]


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


@pytest.mark.parametrize("bits", [14, 16, 18])
def test_step_is_found_in_numbers_of_eight_decimals(bits: int) -> None:
    """Errors of a step add up over the stroke."""
    step = 2 * np.pi / 2**bits
    slow = 1.7 * np.sin(np.linspace(0.0, 2.0, 60_000))
    angles = np.round(step * np.round(slow / step), 8)
    assert encoder_step(angles[:, None]) == pytest.approx([step], rel=1e-5)


def test_angles_without_steps_have_none() -> None:
    assert encoder_step(noisy(2e-6)) == pytest.approx([0.0, 0.0])


def test_curvature_is_that_of_the_hann_window() -> None:
    window = 0.02
    t = np.arange(-window / 2, window / 2 + TS / 2, TS)
    weights = np.cos(np.pi * t / window) ** 2
    by_hand = np.linalg.norm(np.diff(np.pad(weights / weights.sum(), 2), 2)) / TS**2
    # sums instead of integrals over twenty samples
    assert curvature(window, TS) == pytest.approx(by_hand, rel=0.05)


@pytest.mark.parametrize("step", [0.0, 0.1, 1.0])
@pytest.mark.parametrize("least", [0.0, 0.3, 3.0])
def test_reversals_are_those_of_all_samples(step: float, least: float) -> None:
    """Only extremes are looked at, and the ends of a stand: as if all samples were."""
    rng = np.random.default_rng(8)
    for _ in range(50):
        angle = np.cumsum(rng.normal(size=80)) * rng.choice([0.1, 1.0])
        angle = np.round(angle / step) * step if step else angle
        assert _reversals(angle, least) == _of_all(angle, least)


def _of_all(angle: Array, least: float) -> list[tuple[int, int, int]]:
    found, way, since = list[tuple[int, int, int]](), 0, 0
    for k, value in enumerate(angle):
        high, low = angle[since : k + 1].max(), angle[since : k + 1].min()
        for sign, far in ((-1, high), (1, low)):
            if way != sign and sign * (value - far) > least:
                there = since + np.flatnonzero(angle[since : k + 1] == far)
                found.append((int(there[0]), int(there[-1]), sign))
                way, since = sign, k
                break
    return found

"""Fast accelerations that the torque does not show, and those that it does."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.regression.unshown import quiet
from flexhex.diagnosis.regression.window import LONGEST, Smoother
from flexhex.diagnosis.runs.differences import motion_of
from flexhex.diagnosis.runs.run import Run, TimeSeries

Array = NDArray[np.float64]
TS, WINDOW, INERTIA = 1e-3, 0.016, 2.0
TIMES = np.arange(0.0, 20.0, TS)
SLOW, FAST = 1.3, 40.0
"""Frequencies [Hz] of the motion, and of one that a mechanism swings at."""


def angle(t: Array, fast: float = 0.0) -> Array:
    """An angle [rad], with a fast part of this size."""
    slow = np.sin(2 * np.pi * SLOW * t) + 0.5 * np.sin(2 * np.pi * 0.37 * t)
    return np.asarray(0.6 * slow + fast * np.sin(2 * np.pi * FAST * t))


def acceleration(t: Array, fast: float = 0.0) -> Array:
    slow = 0.6 * (2 * np.pi * SLOW) ** 2 * np.sin(2 * np.pi * SLOW * t)
    slow = slow + 0.3 * (2 * np.pi * 0.37) ** 2 * np.sin(2 * np.pi * 0.37 * t)
    return np.asarray(-slow - fast * (2 * np.pi * FAST) ** 2 * np.sin(2 * np.pi * FAST * t))


def held(t: Array) -> Array:
    """When the samples of a log are from that takes every 16th one twice and leaves out another."""
    late = np.arange(len(t)) % 16 < 7
    return np.where(late, t - TS, t)


def asked(theta: Array, torque: Array) -> Smoother | None:
    """What is asked for beside a model of the inertia, of logs of angle and torque."""
    valid = np.ones(len(TIMES), dtype=bool)
    motion = motion_of(TimeSeries(0.0, TS, theta[:, None], valid), None)
    tau = TimeSeries(0.0, TS, torque[:, None], valid)
    run = Run("one", "one", motion, np.ones(len(motion.theta), dtype=bool), tau)
    base: Any = SimpleNamespace(
        n=1,
        window=WINDOW,
        spacing=WINDOW,
        linear=[SimpleNamespace(nominal=INERTIA)],
        torque=lambda motion, p: p[0] * motion.thetadd,
    )
    block = SimpleNamespace(at=TIMES[::16])
    model: Any = SimpleNamespace(base=base, blocks=[block], torque_rms=np.array([torque.std()]))
    return quiet(model, [run], WINDOW)


def test_samples_that_were_held_ask_for_a_longer_window() -> None:
    longer = asked(angle(held(TIMES)), INERTIA * acceleration(TIMES))
    assert longer is not None
    assert 2 * WINDOW <= longer.window <= LONGEST * WINDOW
    assert "fast accelerations of axis 1 would take" in longer.text
    assert longer.text.endswith("instead of 16")


@pytest.mark.parametrize("part", [1.0, 0.3], ids=["rigid", "beyond a resonance"])
def test_fast_motion_that_the_torque_shows_is_none_of_noise(part: float) -> None:
    """All of it, or what a mechanism that swings leaves of it."""
    torque = INERTIA * (acceleration(TIMES) + part * acceleration(TIMES, 1e-3))
    assert asked(angle(TIMES, 1e-3), torque) is None


def test_noise_of_the_torque_says_nothing_of_the_motion() -> None:
    """Also where there is more of it than of the torque of a fast motion."""
    rng = np.random.default_rng(4)
    torque = INERTIA * acceleration(TIMES, 5e-4)
    noise = 3.0 * torque.std() * rng.normal(size=len(TIMES))
    assert asked(angle(TIMES, 5e-4), torque + noise) is None


def test_inertia_that_is_far_off_is_no_noise() -> None:
    """The torque goes with the motion all the same."""
    assert asked(angle(TIMES), 0.2 * INERTIA * acceleration(TIMES)) is None


def test_motion_that_the_torque_has_nothing_of_is_none_of_noise() -> None:
    """A balanced axis, or a force in other units: a longer window takes nothing of it away."""
    rng = np.random.default_rng(3)
    friction = 20.0 * np.sign(np.cos(2 * np.pi * 0.37 * TIMES)) + rng.normal(size=len(TIMES))
    swung = 1e-3 * np.sin(2 * np.pi * 20.0 * TIMES)
    assert asked(angle(TIMES) + swung, friction) is None
    assert asked(angle(held(TIMES)) + swung, friction) is not None, "it would be asked for"

"""Motions drawn at random, ended at random: refused before power, or landed within the stroke."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.gateway.motions import FREE, LIFTED, LIMIT, PUSH, Motion, drawn, ended, run
from tests.gateway.test_falls import push
from tests.gateway.test_singular import BRAKE_S, began, played
from tests.gateway.weight import TS

SEED, COUNT = 27112026, 48


def test_axis_that_is_pushed_towards_its_stop_brakes_sooner(
    hexapod_ssp: Path, tmp_path: Path
) -> None:
    """At 0.508 rad with 1.1 rad/s: a brake of `brake_ms` ends at 0.56 rad, on the stop; a shorter
    one passes the limit and goes back."""
    fallen = run(Motion((1, -1, 1, 1, -1, 1), 0.493, 0.675, 0.86, "push"), hexapod_ssp, tmp_path)
    ran = fallen.ran
    assert ran.code == 0, ran.words
    axis, time = next((k, t) for k, t in enumerate(ran.one("summary")["brakes_s"], 1) if t)
    assert axis == 4
    since = began(fallen)
    rate = (fallen.theta[since, 3] - fallen.theta[since - 8, 3]) / (8 * TS)
    soonest = 2 * (LIMIT - fallen.theta[since, 3]) / rate
    # half of the first rate on average; the torque of a landing does not allow the soonest
    assert 0.95 * soonest < time < 0.5 * BRAKE_S
    assert ran.one("summary")["passed_limits"] == [False, False, False, True, False, False]
    assert f"braked     axis 4 in {1000 * time:.0f} ms, no sooner by landing.torque" in ran.words
    assert LIMIT < np.abs(fallen.theta).max() < FREE


def test_axis_that_creeps_over_its_limit_is_braked_without_a_kick(
    hexapod_ssp: Path, tmp_path: Path
) -> None:
    """It would have to stand at once: its brake is as long as the step of the torque allows."""
    creeps = {"options": push(4.2, PUSH, LIFTED + round(0.9 / TS))}
    lower = ("position_max_rad = 0.52", "position_max_rad = 0.29")
    way = ((1,) * 6, 0.28, 0.6)
    ran = played(hexapod_ssp, tmp_path, way, seconds=3.0, changes=(lower,), **creeps).ran
    assert ran.one("trip")["reason"] == "position"
    summary = ran.one("summary")
    assert summary["landing_trip"] is None
    # 8 * 6 N m / 2 N m cycles
    assert summary["brakes_s"][3] == pytest.approx(24 * TS)
    assert summary["share_of_limits"]["torque_step"] < 0.5


@pytest.mark.sample(3)
@pytest.mark.parametrize("motion", list(drawn(SEED, COUNT)), ids=str)
def test_motion_is_refused_before_power_or_lands(
    motion: Motion, hexapod_ssp: Path, tmp_path: Path
) -> None:
    """A machine that does what it is told; faults and end at any time."""
    ended(motion, hexapod_ssp, tmp_path)


@pytest.mark.sample(1)
@pytest.mark.parametrize("motion", list(drawn(SEED + 1, 12)), ids=str)
def test_motion_of_another_machine_is_refused_before_power_or_lands(
    motion: Motion, hexapod_ssp: Path, machine_ssp: Path, tmp_path: Path
) -> None:
    """The same of a machine whose masses, friction and drives are not those of the model."""
    ended(motion, hexapod_ssp, tmp_path, machine_ssp)

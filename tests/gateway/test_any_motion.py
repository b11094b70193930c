"""Motions drawn at random, ended at random: refused before power, or landed within the stroke."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flexhex.fmus.common.errors import TrajectoryError
from tests.gateway.bench import Process, never_enabled
from tests.gateway.test_falls import fault, push
from tests.gateway.test_singular import BEGIN_S, BRAKE_S, began, played
from tests.gateway.weight import STROKE, TS, Fallen

SEED, COUNT = 27112026, 48
LIFTED, OTHER_LIFTED = 11_644, 16_001
"""Cycles from enabling to the first of the controller; of another machine, which rests lower."""
PUSH = 80
"""Cycles of a push."""
ENDS = ("done", "ctrl-c", "speed", "push")
LIMIT = 0.52
"""Position limit of the template [rad]."""
SLOW = 0.5
"""Twice the speed of a landing [rad/s]."""


@dataclass(frozen=True)
class Motion:
    """From rest to rest; at `end` [s] the run is over, or Ctrl-C, a rule or a push ends it."""

    signs: tuple[int, ...]
    far: float
    time: float
    end: float
    how: str

    @property
    def peak(self) -> float:
        """Highest speed of the whole motion [rad/s]."""
        return 1.875 * self.far / self.time

    def __str__(self) -> str:
        signs = "".join("+" if sign > 0 else "-" for sign in self.signs)
        return f"{signs} {self.far} rad in {self.time} s, {self.how} at {self.end} s"


def drawn(seed: int, count: int) -> Iterator[Motion]:
    """So many motions of a seed."""
    chance = np.random.default_rng(seed)
    for _ in range(count):
        signs = tuple(int(sign) for sign in chance.choice([-1, 1], 6))
        far, time = round(chance.uniform(0.2, 0.5), 3), round(chance.uniform(0.4, 1.5), 3)
        end = round(BEGIN_S + time * chance.uniform(0.05, 1.3), 3)
        yield Motion(signs, far, time, end, str(chance.choice(ENDS)))


def interrupt(gateway: Process, drives: Process) -> None:
    """Ctrl-C in the cycle in which the drives stand still."""
    gateway.send_signal(signal.SIGINT)
    drives.send_signal(signal.SIGCONT)


def over(motion: Motion, plant: Path | None) -> int:
    """Cycle since enabling in which a motion is over."""
    return (OTHER_LIFTED if plant else LIFTED) + round(motion.end / TS)


def run(motion: Motion, ssp: Path, folder: Path, plant: Path | None = None) -> Fallen:
    """Lift-off, as much of the motion as there is, landing."""
    at, more = over(motion, plant), {}
    seconds = motion.end
    if motion.how == "ctrl-c":
        seconds = 10.0
        more = {"options": fault("pause", at), "paused": interrupt}
    elif motion.how == "push":
        more = {"options": push(8, PUSH, at - PUSH)}
    elif motion.how == "speed":
        # a limit that the motion meets about there
        share = 0.95 * motion.peak * min(1.0, motion.end / motion.time)
        seconds = 10.0
        limit = ("speed_rad_per_s = 3.0", f"speed_rad_per_s = {max(0.4, share):.3f}")
        more = {"changes": (limit,)}
    way = (motion.signs, motion.far, motion.time)
    arguments: dict[str, Any] = {"seconds": seconds, "plant": plant, **more}
    return played(ssp, folder, way, **arguments)


def ended(motion: Motion, ssp: Path, folder: Path, plant: Path | None = None) -> str:
    """What became of a motion; raises AssertionError for what must not."""
    try:
        fallen = run(motion, ssp, folder, plant)
    except TrajectoryError as error:
        return f"refused: {str(error).partition(', ')[2]}"
    if fallen.ran.code == 3:
        never_enabled(fallen.ran)
        message = str(fallen.ran.one("refused")["message"])
        assert message.startswith("the motion of the run, "), message
        return f"refused: {message}"
    since, summary = began(fallen), fallen.ran.one("summary")
    if motion.how == "push":
        # what a push does to the speed is not what the landing does
        since = max(since, over(motion, plant))
    trips = [e["reason"] for e in fallen.ran.events if e["event"] == "trip"]
    before, after = fallen.speed[since - 2 : since + 3].max(), fallen.speed[since:].max()
    angle = np.abs(fallen.theta[since:]).max()
    text = f"{trips}, landed: {before:.3f} rad/s, then {after:.3f}; {angle:.4f} rad"
    assert summary["not_disabled"] == [], text
    assert after <= max(SLOW, 1.05 * before), text
    assert summary["landing_trip"] is None, f"{text}; {summary['landing_trip']}"
    assert angle < STROKE, text
    fallen.ends_at_rest(since)
    return text


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
    assert LIMIT < np.abs(fallen.theta).max() < STROKE


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

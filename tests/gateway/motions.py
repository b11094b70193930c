"""Motions drawn at random, and what ends them: `python -m tests.gateway.sweep` runs many."""

from __future__ import annotations

import signal
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from flexhex.fmus.common.errors import TrajectoryError
from tests.gateway.bench import Process, never_enabled
from tests.gateway.test_falls import fault, push
from tests.gateway.test_singular import BEGIN_S, began, played
from tests.gateway.weight import FASTEST, STROKE, TS, Fallen

LIFTED, OTHER_LIFTED = 11_644, 16_001
"""Cycles from enabling to the first of the controller; of another machine, which rests lower."""
PUSH = 80
"""Cycles of a push."""
ENDS = ("done", "ctrl-c", "speed", "push")
FAULTS = ("drive_fault", "sto", "encoder_jump", "encoder_frozen", "cable_cut")
"""Faults of the emulator after which no drive, or not every one, can hold the machine."""
HELD_BY_FIVE = ("drive_fault", "encoder_jump", "encoder_frozen")
"""Those that lead to `damp`: five drives land the machine, one brakes its axis."""
JUMP = 1_000_000
"""Counts: 1.5 mrad."""
LIMIT = 0.52
"""Position limit of the template [rad]."""
SLOW = 0.5
"""Twice the speed of a landing [rad/s]."""
FREE = STROKE - FASTEST * TS
"""Nearer to its stop than the way of a cycle, an axis may have touched it [rad]."""


@dataclass(frozen=True)
class Motion:
    """From rest to rest; at `end` [s] the run is over, or Ctrl-C, a rule, a push or a fault ends
    it."""

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


def drawn(seed: int, count: int, hows: Sequence[str] = ENDS) -> Iterator[Motion]:
    """So many motions of a seed, with ends of these kinds."""
    chance = np.random.default_rng(seed)
    for _ in range(count):
        signs = tuple(int(sign) for sign in chance.choice([-1, 1], 6))
        far, time = round(chance.uniform(0.2, 0.5), 3), round(chance.uniform(0.4, 1.5), 3)
        end = round(BEGIN_S + time * chance.uniform(0.05, 1.3), 3)
        yield Motion(signs, far, time, end, str(chance.choice(hows)))


def interrupt(gateway: Process, drives: Process) -> None:
    """Ctrl-C in the cycle in which the drives stand still."""
    gateway.send_signal(signal.SIGINT)
    drives.send_signal(signal.SIGCONT)


def over(motion: Motion, plant: Path | None) -> int:
    """Cycle since enabling in which a motion is over."""
    return (OTHER_LIFTED if plant else LIFTED) + round(motion.end / TS)


def run(
    motion: Motion, ssp: Path, folder: Path, plant: Path | None = None, stop: str | None = None
) -> Fallen:
    """Lift-off, as much of the motion as there is, landing; stop: in the place of `damp`."""
    at, more = over(motion, plant), {}
    seconds = motion.end
    if motion.how == "ctrl-c":
        seconds = 10.0
        more = {"options": fault("pause", at), "paused": interrupt}
    elif motion.how == "push":
        more = {"options": push(8, PUSH, at - PUSH)}
    elif motion.how in FAULTS:
        seconds = 10.0
        size = {"size": JUMP} if motion.how == "encoder_jump" else {}
        more = {"options": fault(motion.how, at, position=3, **size)}
        if stop is not None:
            more["changes"] = (
                ('frozen_encoder = "damp"', f'frozen_encoder = "{stop}"\njump = "{stop}"'),
                ('drive_fault = "damp"', f'drive_fault = "{stop}"'),
            )
    elif motion.how == "speed":
        # a limit that the motion meets about there
        share = 0.95 * motion.peak * min(1.0, motion.end / motion.time)
        seconds = 10.0
        limit = ("speed_rad_per_s = 3.0", f"speed_rad_per_s = {max(0.4, share):.3f}")
        more = {"changes": (limit,)}
    way = (motion.signs, motion.far, motion.time)
    arguments: dict[str, Any] = {"seconds": seconds, "plant": plant, **more}
    return played(ssp, folder, way, **arguments)


def ended(
    motion: Motion, ssp: Path, folder: Path, plant: Path | None = None, stop: str | None = None
) -> str:
    """What became of a motion; raises AssertionError for what must not."""
    try:
        fallen = run(motion, ssp, folder, plant, stop)
    except TrajectoryError as error:
        return f"refused: {str(error).partition(', ')[2]}"
    if fallen.ran.code == 3:
        never_enabled(fallen.ran)
        message = str(fallen.ran.one("refused")["message"])
        assert message.startswith("the motion of the run, "), message
        return f"refused: {message}"
    if motion.how in FAULTS:
        return fell(fallen)
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
    # near a singular pose a landing goes on
    told = summary["landing_trip"]
    assert told is None or "singular pose is near" in told, f"{text}; {told}"
    assert angle < FREE, text
    fallen.ends_at_rest(since)
    return text


def fell(fallen: Fallen) -> str:
    """What became of a machine that lost the power of one axis, or of all: from then on the drives
    brake these, and no torque of the gateway."""
    trips = [e["reason"] for e in fallen.ran.events if e["event"] == "trip"]
    lost = sorted(int(e["cycle"]) for e in fallen.ran.happened("torque_zero"))
    one = [e["reaction"] for e in fallen.ran.events if e["event"] == "trip"] == ["damp"]
    since = lost[0] if one else lost[-1]
    angle, after = np.abs(fallen.theta[since:]).max(), fallen.speed[since:].max()
    before = fallen.speed[since - 8 : since + 1].max()
    how = "one axis fell" if one else "fell"
    text = f"{trips}, {how}: {before:.3f} rad/s, then {after:.3f}; {angle:.4f} rad"
    assert len(trips) == 1, text
    assert angle <= STROKE, text
    assert np.ptp(fallen.theta[-2000:], axis=0).max() < 0.1, f"{text}: it does not rest"
    fast = ", faster than 1 rad/s" if after > max(FASTEST, 1.02 * before) else ""
    return f"{text}{fast}{', on its stop' if angle >= FREE else ''}"

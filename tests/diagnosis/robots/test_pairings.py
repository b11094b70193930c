"""Every way to pair a six-axis arm with a log wrongly: what is refused, what is said, what is not
seen. The log itself is that of the arm, with friction on all axes; masses of its file are wrong."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Motion
from flexhex.diagnosis.basemodels.robot_file import read_robot
from flexhex.diagnosis.basemodels.robots import RobotBase
from flexhex.diagnosis.basemodels.tolerances import RobotTolerance
from flexhex.diagnosis.runs.pairing import doubtful, mispaired
from flexhex.diagnosis.runs.run import Run, TimeSeries
from tests.diagnosis.robots.simulated import EVERY, FILE, SECONDS, STEP, machine, wanted

pytest.importorskip("pinocchio", reason="the extra `robots` is not installed")
import mujoco

Array = NDArray[np.float64]
Change = Callable[[Array], Array]
FRICTION = np.array([3.0, 4.0, 2.5, 1.0, 0.8, 0.3])
N, TS = 6, EVERY * STEP
REFUSED, SAID, SILENT = "refused", "said", ""


def same(values: Array) -> Array:
    return values


def only(axis: int, factor: float) -> Array:
    return np.where(np.arange(N) == axis, factor, 1.0)


def exchanged(i: int, j: int) -> list[int]:
    order = list(range(N))
    order[i], order[j] = j, i
    return order


@cache
def logged() -> list[tuple[Array, ...]]:
    """Angles, rates, accelerations and torques (samples, 6) of two motions, by MuJoCo."""
    model, torques = machine((0.0,) * N), []
    t = np.arange(0, SECONDS, 5 * TS)
    for seed in (1, 2):
        moved = wanted(t, seed)
        data, tau = mujoco.MjData(model), np.empty((len(t), N))
        for k, (q, v, a) in enumerate(zip(*moved, strict=True)):
            data.qpos[:], data.qvel[:], data.qacc[:] = q, v, a
            mujoco.mj_inverse(model, data)
            tau[k] = data.qfrc_inverse
        torques.append((*moved, tau + FRICTION * np.tanh(moved[1] / 0.01)))
    return torques


def messages(angle: Change, torque: Change, zero: Array | float = 0.0, file: Path = FILE) -> str:
    """Whether such logs are refused, and what is said."""
    runs = []
    for seed, (q, v, a, tau) in enumerate(logged()):
        motion = Motion(0.0, 5 * TS, angle(q) + zero, angle(v), angle(a))
        valid = np.ones(len(q), dtype=bool)
        signal = TimeSeries(0.0, 5 * TS, torque(tau), valid)
        runs.append(Run(str(seed), str(seed), motion, valid, signal))
    base = RobotBase(file, read_robot(file, (), N), RobotTolerance(), 5 * TS)
    if text := mispaired(base, runs):
        return f"{REFUSED}: {text}"
    return f"{SAID}: {text}" if (text := doubtful(base, runs)) else SILENT


def _cases() -> dict[str, tuple[Change, Change]]:
    """Wrong logs by what mends them."""
    cases: dict[str, tuple[Change, Change]] = {}
    for i in range(N):
        sign, axis = only(i, -1.0), i + 1
        cases[f"the torque of axis {axis} negated"] = (same, lambda x, s=sign: x * s)
        cases[f"the angle of axis {axis} negated"] = (lambda x, s=sign: x * s, same)
        degrees = only(i, 180 / np.pi)
        text = f"the angle of axis {axis} taken as degrees, not radians"
        cases[text] = (lambda x, s=degrees: x * s, same)
    for i, j in combinations(range(N), 2):
        order = exchanged(i, j)

        def both(x: Array, o: list[int] = order) -> Array:
            return x[:, o]

        if (i, j) not in FAINT:
            cases[f"with axes {i + 1} and {j + 1} exchanged"] = (both, both)
        cases[f"the torques of axes {i + 1} and {j + 1} exchanged"] = (same, both)
    cases["the axes in reverse order"] = (lambda x: x[:, ::-1],) * 2
    cases["axis 2 as the first"] = (lambda x: np.roll(x, 1, axis=1),) * 2
    cases["angles taken as degrees"] = (np.rad2deg, same)
    cases["angles taken as radians"] = (np.deg2rad, same)
    cases["torques of a thousandth"] = (same, lambda x: 1e3 * x)
    cases["torques of a thousand times"] = (same, lambda x: 1e-3 * x)
    cases["all torques negated"] = (same, np.negative)
    return cases


FAINT = ((3, 4), (3, 5))
"""Axes of the wrist whose torque is mostly friction: whose is whose is hardly seen."""
CASES = _cases()


def test_the_right_log_passes_in_silence() -> None:
    assert messages(same, same) == SILENT


@pytest.mark.sample(6)
@pytest.mark.parametrize("mend", CASES)
def test_a_wrong_log_is_refused_with_what_mends_it(mend: str) -> None:
    text = messages(*CASES[mend])
    assert text.startswith(REFUSED), text or "nothing"
    assert mend in text


def test_another_zero_is_said() -> None:
    """It looks like an effect that the machine may have, too."""
    text = messages(same, same, np.array([0, np.pi / 2, 0, 0, 0, 0]))
    assert text.startswith(SAID)
    assert "90 degrees taken from the angle of axis 2" in text


def test_another_robot_is_not_taken_in_silence(tmp_path: Path) -> None:
    other, text = tmp_path / "other.urdf", FILE.read_text()
    # another axis at the shoulder, a shorter upper arm
    for old, new in (('"0 0 0.45"', '"0 0 0.2"'), ('"0 1 0"', '"1 0 0"')):
        assert old in text
        text = text.replace(old, new, 1)
    other.write_text(text)
    assert messages(same, same, file=other).startswith((REFUSED, SAID))


def test_what_looks_the_same_is_not_refused() -> None:
    """Mirrored angles and torques, which one axis of the wrist alone contradicts; thousand times
    the torque where friction and a rotor explain all of it."""
    assert messages(np.negative, np.negative).startswith(SAID)
    assert messages(same, lambda x: x * only(5, 1e3)) == SILENT

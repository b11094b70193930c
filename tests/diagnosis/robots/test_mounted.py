"""An arm that stands otherwise than its file says: on a wall, under a ceiling; and torques without
the weight."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Motion
from flexhex.diagnosis.basemodels.robot_file import read_robot
from flexhex.diagnosis.basemodels.robots import RobotBase
from flexhex.diagnosis.basemodels.tolerances import RobotTolerance
from flexhex.diagnosis.runs.pairing import mispaired
from flexhex.diagnosis.runs.run import Run, TimeSeries
from tests.diagnosis.robots.simulated import FILE, SECONDS, machine, wanted

pytest.importorskip("pinocchio", reason="the extra `robots` is not installed")
import mujoco

Array = NDArray[np.float64]
TS, N = 0.01, 6
FRICTION = np.array([3.0, 4.0, 2.5, 1.0, 0.8, 0.3])


def refused(gravity: tuple[float, float, float], offset: float = 0.0) -> str:
    """What is said of the torques of two motions under this gravity [m/s2], by MuJoCo, of an arm
    whose masses are not those of the file; with friction, and an offset [N m]."""
    model = machine((0.0,) * N)
    model.opt.gravity[:] = gravity
    t, runs = np.arange(0, SECONDS, TS), list[Run]()
    data, valid = mujoco.MjData(model), np.ones(len(t), dtype=bool)
    for seed in (1, 2):
        moved = wanted(t, seed)
        tau = np.empty((len(t), N))
        for k, (q, v, a) in enumerate(zip(*moved, strict=True)):
            data.qpos[:], data.qvel[:], data.qacc[:] = q, v, a
            mujoco.mj_inverse(model, data)
            tau[k] = data.qfrc_inverse
        tau += FRICTION * np.tanh(moved[1] / 0.01) + offset
        series = TimeSeries(0.0, TS, tau, valid)
        runs.append(Run(str(seed), str(seed), Motion(0.0, TS, *moved), valid, series))
    return mispaired(RobotBase(FILE, read_robot(FILE, (), N), RobotTolerance(), TS), runs)


@pytest.mark.parametrize(
    ("gravity", "said"),
    [
        ((9.81, 0.0, 0.0), "[9.8, "),
        ((0.0, -9.81, 0.0), ", -9.8, "),
        ((0.0, 0.0, 9.81), ", 9.8] m/s2"),
    ],
    ids=["wall", "another wall", "ceiling"],
)
def test_machine_that_stands_otherwise_is_told_how(
    gravity: tuple[float, float, float], said: str
) -> None:
    text = refused(gravity, 0.5)
    assert said in text
    assert "does the machine stand otherwise than its file says?" in text


def test_torques_without_the_weight_are_told() -> None:
    """As controllers log them that take it off."""
    text = refused((0.0, 0.0, 0.0))
    assert "gravity = [0, 0, 0] m/s2 in the frame of the foot (do the logged torques" in text


@pytest.mark.parametrize("tilt", [0.0, 0.09])
def test_machine_whose_feet_are_uneven_is_not_refused(tilt: float) -> None:
    """That is a parameter, which the search names."""
    assert refused((9.81 * np.sin(tilt), 0.0, -9.81 * np.cos(tilt))) == ""

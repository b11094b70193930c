"""An axis whose angle and torque both count the other way round is told by what couples it."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Motion
from flexhex.diagnosis.basemodels.robot_file import read_robot
from flexhex.diagnosis.basemodels.robots import RobotBase
from flexhex.diagnosis.basemodels.tolerances import RobotTolerance
from flexhex.diagnosis.runs.pairing import doubtful, mispaired
from flexhex.diagnosis.runs.run import Run, TimeSeries
from tests.diagnosis.estimation.machines import inverse, moved

pytest.importorskip("pinocchio", reason="the extra `robots` is not installed")

Array = NDArray[np.float64]
TS, SECONDS, N = 2e-3, 10.0, 3
ASIDE = 0.03
"""How far the upper arm stands out to a side of the first axis [m]; 0: its own mirror image."""
DRY, SHARP, NOISE = np.array([32.0, 24.0, 8.0]), 0.3, 0.02
"""Friction [N m], far more than what couples; the rate within which it turns over, and noise,
relative to RMS rate and torque."""
ARM = """<mujoco><compiler angle="radian"/><worldbody><body name="column">
<joint name="yaw" type="hinge" axis="0 0 1"/>
<inertial pos="0 0 .1" mass="6" diaginertia=".05 .05 .04"/>
<body name="upper" pos="0 {aside} .2"><joint name="a" type="hinge" axis="0 1 0"/>
<inertial pos=".2 {centre} 0" mass="4" diaginertia=".01 .08 .08"/>
<body name="lower" pos=".45 {aside} 0"><joint name="b" type="hinge" axis="0 1 0"/>
<inertial pos=".15 0 0" mass="2.5" diaginertia=".005 .03 .03"/>
</body></body></body></worldbody></mujoco>
"""


def said(
    folder: Path, aside: float, signs: tuple[float, ...], turned: float = 1.0
) -> tuple[str, str]:
    """What is refused and what is doubted of logs with angles and torques times these signs.

    turned: 1, or -1 for a machine that stands out to the other side than its file.
    """
    text = ARM.format(aside=aside, centre=-aside / 2)
    (folder / "arm.xml").write_text(text)
    own = ARM.format(aside=turned * aside, centre=-turned * aside / 2)
    machine, rng = mujoco.MjModel.from_xml_string(own), np.random.default_rng(4)
    machine.body_mass *= 1 + 0.1 * rng.choice([-1.0, 1.0], machine.nbody)
    machine.dof_armature[:] = (0.3, 0.2, 0.05)
    t, sign, runs = np.arange(round(SECONDS / TS)) * TS, np.array(signs), []
    for seed in (1, 2):
        q, v, a = moved(t, seed, (0.8, 0.6, 0.8))
        tau = inverse(machine, q, v, a) + DRY * np.tanh(v / (SHARP * v.std(axis=0)))
        tau += NOISE * tau.std(axis=0) * rng.standard_normal(tau.shape)
        valid = np.ones(len(t), dtype=bool)
        series = TimeSeries(0.0, TS, sign * tau, valid)
        runs.append(
            Run(str(seed), str(seed), Motion(0.0, TS, sign * q, sign * v, sign * a), valid, series)
        )
    base = RobotBase(
        folder / "arm.xml", read_robot(folder / "arm.xml", (), N), RobotTolerance(), TS
    )
    return mispaired(base, runs), doubtful(base, runs)


RIGHT, FIRST = (1.0, 1.0, 1.0), (-1.0, 1.0, 1.0)


def test_first_axis_that_counts_the_other_way_round_is_told(tmp_path: Path) -> None:
    refused, doubted = said(tmp_path, ASIDE, FIRST)
    assert refused == "", "friction hides it from what is left: no arrangement is four times better"
    assert doubted.startswith("less would be left with angle and torque of axis 1 negated")


def test_first_axis_of_an_arm_far_out_to_a_side_is_refused(tmp_path: Path) -> None:
    refused, _ = said(tmp_path, 4 * ASIDE, FIRST)
    assert "angle and torque of axis 1 negated" in refused


@pytest.mark.parametrize("aside", [0.0, ASIDE, 4 * ASIDE])
def test_right_signs_are_silent(aside: float, tmp_path: Path) -> None:
    assert said(tmp_path, aside, RIGHT) == ("", "")


def test_arm_that_is_its_own_mirror_image_cannot_tell(tmp_path: Path) -> None:
    assert said(tmp_path, 0.0, FIRST) == ("", "")


def test_machine_that_mirrors_its_file_looks_the_same(tmp_path: Path) -> None:
    """All that can be seen: it is told, and the user knows which of both is wrong."""
    assert "axis 1 negated" in said(tmp_path, ASIDE, RIGHT, turned=-1.0)[1]

"""An SDF is the robot that its URDF is; what URDF cannot say is refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Motion
from flexhex.diagnosis.basemodels.robot_file import read_robot
from flexhex.diagnosis.basemodels.robots import RobotBase
from flexhex.diagnosis.basemodels.tolerances import RobotTolerance
from flexhex.fmus.common.errors import MachineError, UsageError
from flexhex.identify.write_other import checked_target
from tests.compare import assert_close

pin: Any = pytest.importorskip("pinocchio", reason="the extra `robots` is not installed")
pytest.importorskip("rod", reason="the extra `robots` is not installed")
Array = NDArray[np.float64]
SHOULDER, SLIDE = (0.0, 0.1, 0.3, 0.1, 0.2, 0.0), (0.3, 0.0, 0.1, 0.0, 0.5, 0.3)
"""Places of the joints in the link before: x, y, z [m], roll, pitch, yaw [rad]."""
URDF = """<robot name="arm"><link name="base"/>
<link name="upper"><inertial><origin xyz="0.1 0.02 0.2"/><mass value="3"/>
<inertia ixx=".05" iyy=".06" izz=".02" ixy=".001" ixz="0" iyz="0"/></inertial></link>
<link name="fore"><inertial><origin xyz="0 0.02 0.1" rpy="0.3 0 0"/><mass value="1"/>
<inertia ixx=".01" iyy=".02" izz=".012" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/>
<origin xyz="0 0.1 0.3" rpy="0.1 0.2 0"/><axis xyz="0 1 0"/><limit effort="1" velocity="1"/></joint>
<joint name="slide" type="prismatic"><parent link="upper"/><child link="fore"/>
<origin xyz="0.3 0 0.1" rpy="0 0.5 0.3"/><axis xyz="0.6 0 0.8"/><limit effort="1" velocity="1"/>
</joint></robot>"""
SDF = """<sdf version="{version}"><model name="arm">
<link name="base"><inertial><mass>5</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia>
</inertial></link><link name="upper">{upper}<inertial><pose>0.1 0.02 0.2 0 0 0</pose><mass>3</mass>
<inertia><ixx>.05</ixx><iyy>.06</iyy><izz>.02</izz><ixy>.001</ixy></inertia></inertial></link>
<link name="fore">{fore}<inertial><pose>0 0.02 0.1 0.3 0 0</pose><mass>1</mass><inertia>
<ixx>.01</ixx><iyy>.02</iyy><izz>.012</izz></inertia></inertial></link>
<joint name="shoulder" type="revolute">{shoulder}<parent>base</parent><child>upper</child>
<axis><xyz>0 1 0</xyz></axis></joint>
<joint name="slide" type="prismatic">{slide}<parent>upper</parent><child>fore</child>
<axis><xyz>0.6 0 0.8</xyz></axis></joint></model></sdf>"""


def rotation(rpy: tuple[float, float, float]) -> Array:
    """Rotation (3, 3) about fixed x, then y, then z."""
    return np.asarray(pin.rpy.rpyToMatrix(*rpy))


def text(pose: tuple[float, ...], of: str = "") -> str:
    """A pose as SDF has it."""
    mark = f' relative_to="{of}"' if of else ""
    return f"<pose{mark}>{' '.join(repr(float(v)) for v in pose)}</pose>"


def new_style() -> str:
    """Links stand in their joints, joints in the links before."""
    return SDF.format(
        version="1.10", upper=text((0,) * 6, "shoulder"), fore=text((0,) * 6, "slide"),
        shoulder=text(SHOULDER, "base"), slide=text(SLIDE, "upper"),
    )  # fmt: skip


def old_style() -> str:
    """Links stand in the model, joints where their links are: Gazebo's classic files."""
    first, second = rotation(SHOULDER[3:]), rotation(SLIDE[3:])
    at = np.array(SHOULDER[:3]) + first @ np.array(SLIDE[:3])
    fore = (*at, *pin.rpy.matrixToRpy(first @ second))
    return SDF.format(version="1.7", upper=text(SHOULDER), fore=text(fore), shoulder="", slide="")


def base(file: Path) -> RobotBase:
    return RobotBase(file, read_robot(file, (), 2), RobotTolerance(), 1e-3)


@pytest.mark.parametrize("style", [new_style, old_style])
def test_torques_are_those_of_the_urdf(tmp_path: Path, style: Any) -> None:
    (tmp_path / "arm.urdf").write_text(URDF)
    (tmp_path / "arm.sdf").write_text(style())
    wanted, actual = (base(tmp_path / f"arm.{kind}") for kind in ("urdf", "sdf"))
    assert actual.robot.joints == ("shoulder", "slide")
    theta, thetad, thetadd = np.random.default_rng(1).standard_normal((3, 20, 2))
    motion = Motion(0.0, 1e-3, theta, thetad, thetadd)
    p = np.array([known.nominal for known in wanted.linear])
    q = np.array([known.nominal for known in actual.linear])
    assert_close(q, p, atol=1e-12, what="parameters")
    assert_close(actual.torque(motion, q), wanted.torque(motion, p), rtol=1e-12, what="torque")


WRONG = {
    "two": ("</model></sdf>", "</model><model name='b'/></sdf>", "wants one <model>"),
    "include": ("</model></sdf>", "<include/></model></sdf>", "no <include>"),
    "mimic": ("<axis><xyz>0 1 0</xyz>", "<axis><mimic joint='slide'/><xyz>0 1 0</xyz>", "coupled"),
    "ball": ('type="revolute"', 'type="ball"', "joint shoulder is of type ball"),
    "screw": ('type="prismatic"', 'type="screw"', "joint slide is of type screw"),
    "no inertia": (
        "<inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia>",
        "",
        "an <inertia> with ixx, iyy, izz",
    ),
    "parent": ("<parent>upper</parent>", "<parent>nobody</parent>", "ROD cannot make a URDF"),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_urdf_cannot_say_is_refused(tmp_path: Path, name: str) -> None:
    old, new, message = WRONG[name]
    file = tmp_path / "arm.sdf"
    assert old in new_style()
    file.write_text(new_style().replace(old, new))
    with pytest.raises(MachineError, match=message):
        base(file)


def test_an_sdf_is_not_written(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"write \.csv or \.json"):
        checked_target(tmp_path / "found.sdf", str(tmp_path / "arm.sdf"))

"""Robots' files: MuJoCo's torques, hidden friction found, files of no machine refused."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.sparse import csr_array, eye_array

from flexhex.diagnosis.basemodels.base import Motion
from flexhex.diagnosis.basemodels.bases import base_of
from flexhex.diagnosis.basemodels.robot_file import is_robot
from flexhex.diagnosis.kinds import LINEAR, ROTARY
from flexhex.diagnosis.logs import Log
from flexhex.diagnosis.workflow import Options, diagnose
from flexhex.fmus.common.errors import MachineError, UsageError
from tests.compare import assert_close
from tests.diagnosis.robots.simulated import DRY, FILE, write

pytest.importorskip("pinocchio", reason="the extra `robots` is not installed")
Array = NDArray[np.float64]
TS, SAMPLES, TURN = 0.002, 20, 1e-6
SAMPLE = csr_array(eye_array(SAMPLES))
TREE = """<mujoco><compiler angle="radian"/><worldbody><body name="cart"><joint name="rail"
 type="slide" axis="1 0 0"/><inertial pos="0 0 .1" mass="2" diaginertia=".1 .1 .1"/>
 <body name="left" pos="0 .2 0"><joint name="a" type="hinge" axis="0 1 0"/>
 <inertial pos=".1 0 -.2" mass="1" diaginertia=".02 .03 .02"/></body>
 <body name="right" pos="0 -.2 0" euler=".3 0 0"><joint name="b" type="hinge" axis="0 1 0"/>
 <inertial pos="0 .1 -.3" mass=".5" diaginertia=".01 .02 .015"/></body></body></worldbody></mujoco>
"""


def log(n: int) -> Log:
    return Log.of("run.csv", TS, *np.zeros((2, SAMPLES, n)))


def motion(n: int) -> Motion:
    return Motion(0.0, TS, *np.random.default_rng(2).standard_normal((3, SAMPLES, n)))


def inverse(model: mujoco.MjModel, moved: Motion) -> Array:
    """MuJoCo's torques (samples, n)."""
    data, torques = mujoco.MjData(model), []
    for q, v, a in zip(moved.theta, moved.thetad, moved.thetadd, strict=True):
        data.qpos[:], data.qvel[:], data.qacc[:] = q, v, a
        mujoco.mj_inverse(model, data)
        torques.append(data.qfrc_inverse.copy())
    return np.array(torques)


def test_arm_has_the_torques_of_mujoco() -> None:
    base, moved = base_of(str(FILE), None, log(6)), motion(6)
    p = np.array([known.nominal for known in base.linear])
    rotors = np.arange(1.0, 7.0)
    wanted = inverse(mujoco.MjModel.from_xml_path(str(FILE)), moved)
    # torques of some 60 N m in double precision
    assert_close(base.torque(moved, p), wanted, atol=1e-11)
    p[60:] = rotors
    assert_close(base.torque(moved, p), wanted + rotors * moved.thetadd, atol=1e-11)
    assert_close(base.rows(moved, SAMPLE) @ p, wanted + rotors * moved.thetadd, atol=1e-11)


def test_tree_of_sliding_and_turning_joints_has_the_torques_of_mujoco(tmp_path: Path) -> None:
    file = tmp_path / "tree.xml"
    file.write_text(TREE)
    order, moved = ("b", "rail", "a"), motion(3)
    base = base_of(str(file), None, log(3), joints=order)
    p = np.array([known.nominal for known in base.linear])
    back = [order.index(name) for name in ("rail", "a", "b")]
    given = Motion(0.0, TS, *(v[:, back] for v in (moved.theta, moved.thetad, moved.thetadd)))
    wanted = inverse(mujoco.MjModel.from_xml_string(TREE), given)
    assert_close(base.torque(moved, p)[:, back], wanted, atol=1e-12)
    assert base.kinds == (ROTARY, LINEAR, ROTARY)  # type: ignore[attr-defined]
    assert base.linear[10].name == "cart.m"


def test_single_joint_has_the_torque_of_mujoco(tmp_path: Path) -> None:
    """Also of a larger file: Pinocchio gives other shapes where one joint is left."""
    file, moved = tmp_path / "tree.xml", motion(1)
    file.write_text(TREE)
    base = base_of(str(file), None, log(1), joints=("a",))
    p = np.array([known.nominal for known in base.linear])
    still = np.zeros((SAMPLES, 3))
    given = Motion(
        0.0, TS, *(still + v * [0, 1, 0] for v in (moved.theta, moved.thetad, moved.thetadd))
    )
    wanted = inverse(mujoco.MjModel.from_xml_string(TREE), given)[:, 1:2]
    assert_close(base.rows(moved, SAMPLE) @ p, wanted, atol=1e-12)
    assert_close(base.torque(moved, p), wanted, atol=1e-12)


DISPLACED: dict[str, Callable[[mujoco.MjModel], None]] = {
    "link_3.y": lambda m: m.body_pos.__setitem__((3, 1), m.body_pos[3, 1] + TURN),
    "link_5.pitch": lambda m: m.body_quat.__setitem__(5, turned((0.0, TURN, 0.0))),
    "gravity.x": lambda m: m.opt.gravity.__setitem__(1, -9.81 * TURN),
}


def turned(angles: tuple[float, float, float]) -> Array:
    return np.array([1.0, *(0.5 * np.array(angles))])


@pytest.mark.parametrize("name", DISPLACED)
def test_column_of_an_error_is_the_difference_of_torques(name: str) -> None:
    base, moved = base_of(str(FILE), None, log(6)), motion(6)
    assert base.geometry is not None
    p = np.array([known.nominal for known in base.linear])
    columns = base.geometry.columns(moved, SAMPLE, p)
    at = [known.name for known in base.geometry.known].index(name)
    model = mujoco.MjModel.from_xml_path(str(FILE))
    before = inverse(model, moved)
    DISPLACED[name](model)
    wanted = (inverse(model, moved) - before) / TURN
    # gravity that turns one way is a foot that turns the other
    sides = [float(np.abs(sign * columns[:, :, at] - wanted).max()) for sign in (1.0, -1.0)]
    best = min(sides) if name.startswith("gravity") else sides[0]
    # differences of torques of some 60 N m over 1e-6, of second order in it
    assert best < 1e-5 * np.abs(wanted).max()


@pytest.mark.parametrize("mass", [0.0, -1.0, -40.0])
def test_columns_of_errors_are_linear_in_masses_that_no_body_has(mass: float) -> None:
    """A fit may ask for them."""
    base, moved = base_of(str(FILE), None, log(6)), motion(6)
    assert base.geometry is not None
    p, last = np.array([known.nominal for known in base.linear]), 50
    more = p.copy()
    more[last] += 1.0
    once, twice = (base.geometry.columns(moved, SAMPLE, values) for values in (p, more))
    wanted = once + (mass - p[last]) * (twice - once)
    p[last] = mass
    # of some 100 N m per unit, times the largest mass
    assert_close(base.geometry.columns(moved, SAMPLE, p), wanted, atol=1e-10)


@pytest.mark.parametrize("axis", ["", '<axis xyz="0 0 0"/>'])
def test_parts_that_are_fixed_belong_to_the_body_before_them(axis: str, tmp_path: Path) -> None:
    (path := tmp_path / "arm.urdf").write_text(ARM.replace('type="fixed">', f'type="fixed">{axis}'))
    (mass,) = [k for k in base_of(str(path), None, log(6)).linear if k.name == "link_6.m"]
    assert_close(mass.nominal, 0.6 + 0.4, atol=1e-12)


def test_joints_that_are_not_chosen_are_locked() -> None:
    base = base_of(str(FILE), None, log(2), joints=("j2", "j3"))
    (mass,) = [known for known in base.linear if known.name == "link_3.m"]
    assert_close(mass.nominal, 3.0 + 2.0 + 1.2 + 0.6 + 0.4, atol=1e-12)


def test_tolerances_are_those_of_the_option() -> None:
    base = base_of(str(FILE), None, log(6), {"mass": 0.2, "geometry": 0.0, "gravity": 0.0})
    (mass,) = [known for known in base.linear if known.name == "link_2.m"]
    assert_close(mass.tolerance, 0.2 * 5.0, atol=1e-12)
    assert base.geometry is None


ARM = FILE.read_text()
INERTIAL = re.compile(r"(<link name=\"link_4\">)<inertial>.*?</inertial>")
WRONG: dict[str, tuple[str, str]] = {
    "no xml": ("robot", "no XML"),
    "root": ("<mujoco/>", "begins with <mujoco>, a .urdf file with <robot>"),
    "no joint": ('<robot name="r"><link name="a"/></robot>', "no joint moves"),
    "floating": (
        ARM.replace('"j3" type="revolute"', '"j3" type="floating"'),
        "joint j3 is a FreeFlyer: an axis turns or slides",
    ),
    "mimic": (
        ARM.replace('<child link="link_5"/>', '<child link="link_5"/><mimic joint="j3"/>'),
        "joint j5 follows j3",
    ),
    "inertial": (INERTIAL.sub(r"\1", ARM), "joint j4 moves has no mass.*for link link_4"),
    "negative": (ARM.replace('value="0.4"', 'value="-0.4"'), "link tool has a mass of -0.4 kg"),
    "axis": (ARM.replace('"0 0 1"', '"0 0 0"', 1), "joint j1 has the axis 0 0 0: no direction"),
    "comma": (ARM.replace('value="1.2"', 'value="1,2"'), r"mass \[1,2\] is not a float"),
    "tag": (ARM.replace('<mass value="1.2"', '<mas value="1.2"'), r"must have a mass element"),
    "type": (
        ARM.replace('"j3" type="revolute"', '"j3" type="revolut"'),
        r"no known type \[revolut\]",
    ),
    "inertia": (ARM.replace('iyy="0.014"', 'iyy="-0.014"'), "link_4 has a negative moment"),
    "link": (
        ARM.replace('parent link="link_3"', 'parent link="link_9"'),
        r"cannot read it: .*\[link_9\]",
    ),
}


@pytest.mark.parametrize("case", WRONG)
def test_file_that_describes_no_machine_is_refused(
    case: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    text, message = WRONG[case]
    (tmp_path / "arm.urdf").write_text(text)
    joints = ("j1", "j2", "j3", "j4", "j5", "j6") if case in ("mimic", "floating") else ()
    with pytest.raises(MachineError, match=message):
        base_of(str(tmp_path / "arm.urdf"), None, log(6), joints=joints)
    assert capfd.readouterr() == ("", ""), "what the parser prints belongs into the message"


CHOICES = {
    "number": ((), r"6 joints \(j1, j2, j3, j4, j5, j6\), the logs have 5 axes.*--joints"),
    "unknown": (("jj2",), r"--joints: jj2 does not exist.*is it j2\?"),
    "fixed": (("flange",), "--joints: flange is fixed"),
    "twice": (("j1", "j1"), "j1 is named twice"),
}


@pytest.mark.parametrize("case", CHOICES)
def test_choice_of_joints_that_cannot_be_is_refused(case: str) -> None:
    joints, message = CHOICES[case]
    with pytest.raises(UsageError, match=message):
        base_of(str(FILE), None, log(5), joints=joints)


def test_closed_loops_are_refused(tmp_path: Path) -> None:
    weld = '<equality><connect body1="left" body2="right" anchor="0 0 0"/></equality></mujoco>'
    (tmp_path / "loop.xml").write_text(TREE.replace("</mujoco>", weld))
    with pytest.raises(MachineError, match="<equality> with <connect>: closed loops"):
        base_of(str(tmp_path / "loop.xml"), None, log(3))


@pytest.mark.parametrize(
    ("name", "message"),
    [("a.xacro", "run `xacro"), ("b.urdf", "no such")],
)
def test_other_files_are_refused(name: str, message: str, tmp_path: Path) -> None:
    (tmp_path / "a.xacro").touch()
    assert is_robot(name)
    with pytest.raises(UsageError, match=message):
        base_of(str(tmp_path / name), None, log(6))


@pytest.mark.slow
def test_file_and_four_runs_name_the_hidden_friction(tmp_path: Path) -> None:
    paths = [write(tmp_path / f"{s}_{k}.csv", s, k) for s in (1, 2) for k in (1, 2)]
    diagnosis = diagnose(paths, options=Options(base=str(FILE)))
    (effect,) = [effect for effect in diagnosis.effects if 3 in effect.axes]
    assert (effect.id, effect.axes) == ("coulomb_friction", (3,))
    # MuJoCo's constraint is soft: it creeps before it slides
    assert_close(effect.parameters["F_c"].value, DRY[2], atol=0.05 * DRY[2])


def test_file_and_four_runs_without_friction_lack_nothing(tmp_path: Path) -> None:
    nothing = (0.0,) * 6
    paths = [write(tmp_path / f"{s}_{k}.csv", s, k, nothing) for s in (1, 2) for k in (1, 2)]
    assert diagnose(paths, options=Options(base=str(FILE))).verdict == "none"

"""A TOML file beside a robot's file: MuJoCo's torques, rotors found, wrong gravity seen."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray

import flexhex
from flexhex.diagnosis.basemodels.base import Motion
from flexhex.diagnosis.basemodels.bases import base_of
from flexhex.diagnosis.basemodels.robots import RobotBase
from flexhex.diagnosis.estimation.identified import identify
from flexhex.diagnosis.logs import Log
from flexhex.diagnosis.workflow import Options
from flexhex.fmus.common.errors import LogError
from tests.compare import assert_close
from tests.diagnosis.robots import walled

pytest.importorskip("pinocchio", reason="the extra `robots` is not installed")
Array = NDArray[np.float64]
LOG = Log.of("run.csv", walled.TS, *np.zeros((2, 20, walled.N)))
MOVED = np.random.default_rng(2).standard_normal((3, 20, walled.N))


def base_for(file: Path, log: Log = LOG, joints: tuple[str, ...] = ()) -> RobotBase:
    base = base_of(str(file), None, log, joints=joints)
    assert isinstance(base, RobotBase)
    return base


def nominal(base: RobotBase) -> Array:
    return np.array([known.nominal for known in base.linear])


def test_gravity_tool_and_rotors_make_the_torques_of_mujoco(tmp_path: Path) -> None:
    base = base_for(walled.files(tmp_path))
    p, arm = nominal(base), walled.model()
    p[base.rotors[0] :] = walled.ROTORS
    wanted = walled.felt(arm, *MOVED)
    # torques of some 60 N m in double precision
    assert_close(base.torque(Motion(0.0, 1.0, *MOVED), p), wanted, atol=1e-11)
    assert_close(base.columns(*MOVED) @ p, wanted, atol=1e-11)


def test_rotor_is_what_the_gear_makes_of_it(tmp_path: Path) -> None:
    base = base_for(walled.files(tmp_path))
    rotors = [base.linear[place] for place in base.rotors]
    told = np.array(walled.SAID) * np.array(walled.GEARS) ** 2
    assert_close([rotor.nominal for rotor in rotors], told, rtol=1e-12)
    assert_close([rotor.tolerance for rotor in rotors], 0.1 * told, rtol=1e-12)
    # one is left free
    text = walled.BESIDE.partition("[rotor.elbow]")[0]
    free = base_for(walled.files(tmp_path, text)).linear[-1]
    assert (free.nominal, free.tolerance) == (0.0, np.inf)


def test_announced_payload_hangs_at_the_tool(tmp_path: Path) -> None:
    base = base_for(walled.files(tmp_path))
    p = base.loaded(nominal(base), 1.3)
    p[base.rotors[0] :] = walled.ROTORS
    # a point at the tool's centre makes it heavier, and its moments about it no larger
    wanted = walled.felt(walled.model(tool=2.6), *MOVED)
    assert_close(base.torque(Motion(0.0, 1.0, *MOVED), p), wanted, atol=1e-11)


def test_tool_without_mass_says_where_payloads_are(tmp_path: Path) -> None:
    text = walled.BESIDE.replace("mass = 1.3", "mass = 0")
    text = text.replace("inertia = [0.004, 0.003, 0.002, 0, 0, 0]", "")
    light, laden = base_for(walled.files(tmp_path, text)), base_for(walled.files(tmp_path))
    assert_close(
        light.loaded(nominal(light), 1.3)[list(light.payload)][:4],
        nominal(laden)[list(laden.payload)][:4],
        atol=1e-12,
    )


def test_options_take_the_place_of_what_the_file_says(tmp_path: Path) -> None:
    text = walled.BESIDE.replace("gravity =", 'joints = ["elbow", "swivel", "shoulder"]\ngravity =')
    file = walled.files(tmp_path, text)
    assert base_for(file).robot.joints == ("elbow", "swivel", "shoulder")
    assert base_for(file).linear[-3].nominal == walled.SAID[2] * walled.GEARS[2] ** 2
    order = ("swivel", "shoulder", "elbow")
    assert base_for(file, joints=order).robot.joints == order
    (mass,) = [k for k in base_for(file).linear if k.name == "arm.m"]
    assert_close(mass.tolerance, 0.1 * 3.0, rtol=1e-12)
    (mass,) = [k for k in base_of(str(file), None, LOG, {"mass": 0.2}).linear if k.name == "arm.m"]
    assert_close(mass.tolerance, 0.2 * 3.0, rtol=1e-12)


def test_without_tolerance_the_file_is_exact(tmp_path: Path) -> None:
    nothing = "".join(
        f"{key} = 0\n" for key in ("mass", "inertia", "centre", "geometry", "gravity")
    )
    text = f'robot = "arm.urdf"\n[tolerance]\n{nothing}'
    base = base_for(walled.files(tmp_path, text))
    assert {known.tolerance for known in base.linear[: base.rotors[0]]} == {0.0}
    assert base.geometry is None


ARMATURE = """<mujoco><compiler angle="radian"/><option gravity="0 -9.81 0"/>
<default><joint armature="0.7"/><default class="wrist"><joint armature="0.2"/></default></default>
<worldbody><body name="cart"><joint name="rail" type="slide" axis="1 0 0"/>
<inertial pos="0 0 .1" mass="2" diaginertia=".1 .1 .1"/>
<body name="left" pos="0 .2 0"><joint name="a" type="hinge" axis="0 1 0" class="wrist"/>
<inertial pos=".1 0 -.2" mass="1" diaginertia=".02 .03 .02"/></body>
<body name="right" pos="0 -.2 0"><joint name="b" type="hinge" axis="0 1 0" armature="0"/>
<inertial pos="0 .1 -.3" mass=".5" diaginertia=".01 .02 .015"/></body></body></worldbody></mujoco>
"""


def test_mjcf_gives_rotors_and_gravity(tmp_path: Path) -> None:
    """Also by its defaults, and what is zero is not known. Pinocchio takes no gravity from it."""
    (tmp_path / "cart.xml").write_text(ARMATURE)
    base = base_for(tmp_path / "cart.xml")
    listed = [(k.name, k.nominal, k.tolerance) for k in base.linear[30:]]
    assert listed == [
        ("m_r[1]", 0.7, pytest.approx(0.05 * 0.7)),
        ("J_r[2]", 0.2, pytest.approx(0.05 * 0.2)),
        ("J_r[3]", 0.0, np.inf),
    ]
    wanted = walled.felt(mujoco.MjModel.from_xml_string(ARMATURE), *MOVED)
    assert_close(base.torque(Motion(0.0, 1.0, *MOVED), nominal(base)), wanted, atol=1e-11)
    # a file beside it knows better
    (tmp_path / "cart.toml").write_text(
        'robot = "cart.xml"\ngravity = [0, 0, 0]\n[rotor.a]\ntolerance = 0.5\n'
        "[rotor.b]\ninertia = 0.001\ngear = 10\n[rotor.rail]\ninertia = 0\n"
    )
    better = base_for(tmp_path / "cart.toml")
    assert [(k.nominal, k.tolerance) for k in better.linear[30:]] == [
        (0.0, 0.0),
        (0.2, pytest.approx(0.1)),
        (pytest.approx(0.1), pytest.approx(0.005)),
    ]
    assert better.robot.model.gravity.linear.tolist() == [0.0, 0.0, 0.0]


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Sequence[Path]:
    """Two motions; the files lie beside them."""
    folder = tmp_path_factory.mktemp("walled")
    walled.files(folder)
    return [walled.run(folder, seed) for seed in (1, 2)]


def test_rotors_of_an_arm_on_a_wall_are_within_their_intervals(runs: Sequence[Path]) -> None:
    identified = flexhex.identify_runs(runs, base=str(runs[0].with_name("arm.toml")))
    for i, true in enumerate(walled.ROTORS, start=1):
        rotor = identified[f"J_r[{i}]"]
        low, high = rotor.estimate.ci95
        assert low < true < high, (i, true, rotor.estimate)
        # what the file beside it says is 3 to 8 % off
        assert rotor.estimate.value == pytest.approx(true, rel=0.03 if i > 1 else 0.1)
    assert (identified.errors.fitted < 0.02).all()
    assert not identified.doubt


@pytest.mark.parametrize("gravity", ["0, 0, -9.81", "0, 9.81, 0", "9.81, 0, 0"])
def test_gravity_of_another_foot_is_seen(runs: Sequence[Path], gravity: str) -> None:
    other = runs[0].with_name("other.toml")
    other.write_text(walled.BESIDE.replace("-9.81, 0.0, 0.0", gravity))
    try:
        doubt = identify(runs, options=Options(str(other))).doubt
    except LogError as error:
        doubt = str(error)
    assert "base model" in doubt or "gravity" in doubt, doubt


def test_rotors_of_a_simulator_do_not_look_like_another_machine(runs: Sequence[Path]) -> None:
    """Files have them for its steps' sake; the pairing of file and logs fits its own."""
    other = runs[0].with_name("other.toml")
    other.write_text(walled.BESIDE.replace("gear = 101.0", "gear = 1010.0"))
    assert not identify(runs, options=Options(str(other))).doubt

"""A TOML file beside a robot's file: every mistake is an error with file and key."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from flexhex.diagnosis.basemodels.bases import base_of
from flexhex.diagnosis.basemodels.robots import RobotBase
from flexhex.diagnosis.logs import Log
from flexhex.diagnosis.machine_files.robot_write import write_robot
from flexhex.fmus.common.errors import MachineError, UsageError
from flexhex.fmus.common.machine_file import load_machine
from tests.conftest import MACHINE_FILE
from tests.diagnosis.robots import walled

pytest.importorskip("pinocchio", reason="the extra `robots` is not installed")
LOG = Log.of("run.csv", walled.TS, *np.zeros((2, 20, walled.N)))
Edit = tuple[str, str]
WRONG: dict[str, tuple[Edit | str, str]] = {
    "no toml": ("robot = ", "not valid TOML"),
    "no robot": ("gravity = [0, 0, 0]", "robot: is missing: add robot = ..."),
    "robot": ("robot = 3", "robot: wants a text in quotes, is 3"),
    "no file": ('robot = "amr.urdf"', r"robot: .*amr\.urdf: no such file"),
    "itself": ('robot = "arm.toml"', r"robot: arm\.toml is no robot's file"),
    "mesh": ('robot = "arm.stl"', r"robot: .*arm\.stl: no robot's file \(.urdf, .xml, .sdf\)"),
    "key": (("gravity =", "gravty ="), "gravty: is not a known key, did you mean gravity"),
    "joints": (("gravity =", 'joints = "elbow"\ngravity ='), "joints: wants a list, is 'elbow'"),
    "number": (("gravity =", "joints = [1, 2, 3]\ngravity ="), "joints.1: wants a text in quotes"),
    "joint": (
        ("gravity =", 'joints = ["swivel", "shoudler", "elbow"]\ngravity ='),
        r"joints: shoudler does not exist in .*arm\.urdf: is it shoulder\?",
    ),
    "fixed": (("gravity =", 'joints = ["flange"]\ngravity ='), "joints: flange is fixed"),
    "twice": (
        ("gravity =", 'joints = ["elbow", "elbow", "swivel"]\ngravity ='),
        "joints: elbow is named twice",
    ),
    "axes": (
        ("gravity =", 'joints = ["elbow"]\ngravity ='),
        r"joints: 1 joints \(elbow\), the logs have 3 axes",
    ),
    "gravity": (("[-9.81, 0.0, 0.0]", "[0, 9.81]"), "gravity: wants 3 entries, has 2"),
    "scalar": (("[-9.81, 0.0, 0.0]", "9.81"), "gravity: wants a list of 3 numbers, is 9.81"),
    "nan": (("-9.81", "nan"), "gravity: nan is not a finite number"),
    "unit": (
        ("[-9.81, 0.0, 0.0]", '{ value = [0, 0, -1], unit = "g" }'),
        "gravity: is in 'g', wanted 'm/s2': convert the value",
    ),
    "tolerance": (("mass = 0.1", "mas = 0.1"), "tolerance.mas: is not a known key, did you mean"),
    "per cent": (("mass = 0.1", "mass = 10"), "tolerance.mass: 10.0, must be at most 1"),
    "table": (("[tolerance]\nmass = 0.1", "tolerance = 0.1\n[x]\nmass = 1"), "tolerance: wants a"),
    "rotor": (("[rotor.elbow]", "[rotor.elbo]"), r"rotor.elbo: no such joint .*: is it elbow\?"),
    "rotors": (("[rotor.elbow]", "[rotor]"), "rotor.inertia: wants a table of keys, is 2.1e-05"),
    "gears": (
        ("gear = 51", "gears = 51"),
        "rotor.elbow.gears: is not a known key, did you mean gear",
    ),
    "negative": (
        ("2.1e-05", "-2.1e-05"),
        "rotor.elbow.inertia: -2.1e-05 kg m2, must be at least 0",
    ),
    "infinite": (("2.1e-05", "inf"), "rotor.elbow.inertia: inf is not a finite number"),
    "text": (("2.1e-05", '"much"'), "rotor.elbow.inertia: value 'much' is not a number"),
    "gear": (("gear = 51.0", "gear = 0"), "rotor.elbow.gear: 0.0, must be above 0"),
    "gear alone": (("inertia = 2.1e-05\n", ""), "rotor.elbow: inertia is missing"),
    "nothing known": (
        ("inertia = 2.1e-05\ngear = 51.0", ""),
        "rotor.elbow: inertia is missing, and .* has no armature of this joint",
    ),
    "doubt": (("tolerance = 0.1", "tolerance = -0.1"), "rotor.swivel.tolerance: -0.1, must be at"),
    "link": (('"tool0"', '"tool1"'), r"tool.link: there is no link tool1 in .*: is it tool0\?"),
    "foot": (('"tool0"', '"wall"'), "tool.link: wall moves with none of the axes"),
    "no link": (('link = "tool0"', ""), "tool.link: is missing: add link = ..."),
    "no mass": (("mass = 1.3", ""), r"tool.mass: is missing: add mass = ... \[kg\]"),
    "mass": (("mass = 1.3", "mass = -1.3"), "tool.mass: -1.3 kg, must be at least 0"),
    "centre": (("[0.01, 0, 0.06]", "[0.01, 0]"), "tool.centre: wants 3 entries, has 2"),
    "inertia": (("[0.004, 0.003", "[-0.004, 0.003"), "tool: inertia has a negative principal"),
    "moments": (("[0.004, 0.003", "[0.4, 0.003"), "tool: no body has the principal moments"),
    "no body": (("mass = 1.3", "mass = 0"), "tool: inertia without a mass"),
}


@pytest.mark.parametrize("case", WRONG)
def test_mistake_is_an_error_with_file_and_key(case: str, tmp_path: Path) -> None:
    edit, message = WRONG[case]
    text = edit if isinstance(edit, str) else walled.BESIDE.replace(*edit, 1)
    assert text != walled.BESIDE
    file = walled.files(tmp_path, text)
    with pytest.raises(MachineError, match=rf"^{re.escape(str(file))}: {message}"):
        base_of(str(file), None, LOG)


def test_missing_file_is_a_wrong_option(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"none\.toml: no such file"):
        base_of(str(tmp_path / "none.toml"), None, LOG)


def test_each_kind_of_toml_says_which_option_takes_it(tmp_path: Path) -> None:
    with pytest.raises(MachineError, match=f"give it as --machine {MACHINE_FILE}"):
        base_of(str(MACHINE_FILE), None, LOG)
    file = walled.files(tmp_path)
    with pytest.raises(MachineError, match=f"give it as --base {file}"):
        load_machine(file)


def built(file: Path) -> tuple[RobotBase, dict[str, float]]:
    base = base_of(str(file), None, LOG)
    assert isinstance(base, RobotBase)
    return base, {known.name: known.nominal for known in base.linear}


def test_written_file_has_the_body_without_the_tool(tmp_path: Path) -> None:
    """The file beside it adds the tool again; it stays the same where the arm was right."""
    base, values = built(walled.files(tmp_path))
    values = {name: 1.2 * value for name, value in values.items()}
    write_robot(tmp_path / "new.urdf", base, base.file, values)
    text = walled.BESIDE.replace("arm.urdf", "new.urdf")
    again, read = built(walled.files(tmp_path, text))
    for known in again.linear[: again.rotors[0]]:
        assert read[known.name] == pytest.approx(values[known.name], rel=1e-9, abs=1e-12)
    (tmp_path / "bare.toml").write_text('robot = "new.urdf"\n')
    _, bare = built(tmp_path / "bare.toml")
    assert bare["fore.m"] == pytest.approx(1.2 * (1.5 + 1.3) - 1.3, rel=1e-9)


def test_body_that_is_lighter_than_its_tool_is_not_written(tmp_path: Path) -> None:
    base, values = built(walled.files(tmp_path))
    values = {name: 0.3 * value for name, value in values.items()}
    with pytest.raises(MachineError, match="tool: what joint elbow moves was found too light"):
        write_robot(tmp_path / "new.urdf", base, base.file, values)
    assert not (tmp_path / "new.urdf").exists()

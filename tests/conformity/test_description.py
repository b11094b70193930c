"""What the FMUs say about themselves: licence, version, units, what may change while they run."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import numpy as np
import pytest
from lxml import etree

import flexhex
from flexhex.fmugen import VERSION
from flexhex.fmugen.blocks import BLOCKS
from flexhex.fmus.common.interface import STRUCTURED, array_of
from tests.adapter.slave import ERROR, OK, Binary, Slave
from tests.conformity.archives import XML, members
from tests.conftest import ROOT

NAMES = (*BLOCKS, "machine")


def test_version_is_that_of_the_package() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert project["dynamic"] == ["version"]
    assert flexhex.__version__ == VERSION


@pytest.mark.parametrize("name", NAMES)
def test_archive_says_who_what_and_under_which_licence(fmu_dir: Path, name: str) -> None:
    files = members(fmu_dir / f"{name}.fmu")
    root = etree.fromstring(files[XML])
    assert root.get("generationTool") == f"flexhex {VERSION}"
    assert root.get("version") == VERSION
    text = files["documentation/licenses/license.txt"].decode()
    assert (ROOT / "LICENSE").read_text().strip() in text
    assert str(root.get("copyright")) in text
    # each file of the archive that others wrote names its licence; the text does so for all
    assert "2-Clause BSD" in text
    assert b"2-Clause BSD" in files["sources/fmi2Functions.h"]
    assert "MIT-0" in text


@pytest.mark.parametrize("name", NAMES)
def test_default_experiment_shows_something(fmu_dir: Path, name: str) -> None:
    """The reference rests for two seconds: an importer's own second would show nothing."""
    root = etree.fromstring(members(fmu_dir / f"{name}.fmu")[XML])
    experiment = root.find("DefaultExperiment")
    assert float(experiment.get("stopTime")) > 2.0
    assert float(experiment.get("stepSize")) == 0.00025


@pytest.mark.parametrize("name", ["kinematics", "feedforward", "estimator"])
def test_coordinates_have_their_own_units(fmu_dir: Path, name: str) -> None:
    """x~ [SH, Eq. (3)]: six angles, six quaternions, position [m] and quaternion of E."""
    root = etree.fromstring(members(fmu_dir / f"{name}.fmu")[XML])
    elements = {v.get("name"): v for v in root.iter("ScalarVariable")}
    for array, rate in (("x", ""), ("xd", "/s"), ("xdd", "/s2")):
        listed = [n for n in elements if array_of(n) == array]
        units = [elements[n].find("Real").get("unit") for n in listed]
        assert units == [f"rad{rate}"] * 6 + [f"1{rate}"] * 24 + [f"m{rate}"] * 3 + [f"1{rate}"] * 4
        assert listed[30:34] == [*(f"{array}.x_E.{axis}" for axis in "xyz"), f"{array}.lam_E[1]"]


@pytest.mark.parametrize("name", NAMES)
def test_names_make_one_tree(fmu_dir: Path, name: str) -> None:
    """Tools draw structured names as a tree: what is an array must be no plain branch too, and
    nothing with a value has branches."""
    root = etree.fromstring(members(fmu_dir / f"{name}.fmu")[XML])
    names = [str(v.get("name")) for v in root.iter("ScalarVariable")]
    assert all(STRUCTURED.fullmatch(n) for n in names)
    leaves, indexed, plain = set(names), set[str](), set[str]()
    for words in (n.split(".") for n in names):
        for k in range(1, len(words) + 1):
            branch = ".".join(words[:k])
            assert k == len(words) or branch not in leaves, f"{branch} has a value and branches"
            (indexed if branch.endswith("]") else plain).add(re.sub(r"\[[\d,]+\]$", "", branch))
    assert not indexed & plain, f"an array and none: {sorted(indexed & plain)}"


def running(fmu_dir: Path, folder: Path) -> tuple[Slave, dict[str, int]]:
    """feedback.fmu after its first steps, and its value references."""
    binary = Binary(fmu_dir / "feedback.fmu", folder)
    named = {v.get("name"): int(v.get("valueReference")) for v in binary.xml.iter("ScalarVariable")}
    slave = Slave(binary).initialise()
    for n in range(4):
        slave.set([named[f"r[{k}]"] for k in range(1, 7)], [1e-3 * n] * 6)
        slave.advance()
    return slave, named


def test_gains_of_the_feedback_may_change_while_it_runs(fmu_dir: Path, tmp_path: Path) -> None:
    """No feedforward counts, then half of it; the next tick's result appears two steps later."""
    slave, vr = running(fmu_dir, tmp_path)
    tau, own = [vr["tau[1]"]], [vr["tau_fb[1]"]]
    assert slave.set([vr["tau_ff[1]"]], [1.0]) == OK
    for share in (0.0, 0.5, 1.0):
        assert slave.set([vr["ff_gain"]], [share]) == OK
        slave.advance(2)
        # tau comes in whole current steps of 0.003 N m
        np.testing.assert_allclose(slave.get(tau)[0] - slave.get(own)[0], share, atol=0.003)
    before = slave.get(own)[0]
    assert slave.set([vr[f"kp[{k}]"] for k in range(1, 7)], [0.0] * 6) == OK
    slave.advance(2)
    assert abs(before) > 0.01
    assert slave.get(own)[0] == 0.0


def test_what_a_start_prepares_may_not_change(fmu_dir: Path, tmp_path: Path) -> None:
    slave, vr = running(fmu_dir, tmp_path)
    for name in ("Ts", "reference_delay", "tau_max", "tau_step"):
        assert slave.set([vr[name]], [0.001]) == ERROR
        assert f"{name} is a fixed parameter" in slave.said


def test_hidden_parameters_explain_themselves(fmu_dir: Path) -> None:
    root = etree.fromstring(members(fmu_dir / "machine.fmu")[XML])
    for v in root.iter("ScalarVariable"):
        if v.get("causality") == "parameter":
            words = re.findall(r"\w+", str(v.get("description")))
            assert len(words) >= 2, f"{v.get('name')}: {v.get('description')!r} says too little"

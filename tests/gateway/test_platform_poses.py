"""`move --pose` and `pose` of `jog`: poses of the platform, by `pose.fmu`."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from flexhex.fmugen.blocks import Source
from flexhex.fmus.common.machine_file import load_machine
from tests.conftest import MACHINE_FILE
from tests.gateway.bench import Bench, Event
from tests.gateway.test_falls import POSE
from tests.gateway.test_jog import jogged
from tests.gateway.test_readback import SHORT
from tests.gateway.weight import free
from tests.oracles.calculus import Array
from tests.oracles.geometry import close
from tests.oracles.machine import read_machine

MOVE = ("move", "--enable", "--lockstep", "--hold", 1.0)
FMU = "../../out/fmus/pose.fmu"
FIRST, SECOND = "2mm,-3e3um,0.31,0,2deg,-10mrad", "0,0,290mm,0,0,0.05rad"
WANTED = np.array(
    [[0.002, -0.003, 0.31, 0, np.radians(2), -0.01], [0, 0, 0.29, 0, 0, 0.05]],
)


def platform(theta: Array) -> Array:
    """Position [m] and rotation vector [rad] (6,) of angles (6,), by an independent model."""
    x = close(read_machine(), np.asarray(theta))
    return np.concatenate([x[30:33], Rotation.from_quat(np.roll(x[33:37], -1)).as_rotvec()])


def told(event: Event, end: str = "") -> Array:
    """The platform (6,) in an event `arrived`."""
    return np.concatenate([event[f"x_E{end}"], event[f"phi_E{end}"]])


def test_platform_moves_through_poses_and_lands(
    hexapod_ssp: Path, fmu_dir: Path, tmp_path: Path
) -> None:
    command = (*MOVE, "--pose", FIRST, "--pose", SECOND)
    changes = [(FMU, str(fmu_dir / "pose.fmu"))]
    fallen = free(Bench(hexapod_ssp, tmp_path), command=command, changes=changes)
    ran = fallen.ran
    assert ran.code == 0, ran.words
    arrived = [e for e in ran.events if e["event"] == "arrived"]
    assert len(arrived) == len(WANTED)
    for e, wanted in zip(arrived, WANTED, strict=True):
        # the closed form of the FMU, with the rounding of both
        assert np.abs(platform(e["pose"]) - wanted).max() < 1e-12
        assert np.abs(told(e, "_ref") - wanted).max() < 1e-9
        # the kinematics FMU stops its iteration at 1e-9
        assert np.abs(told(e) - platform(e["theta"])).max() < 1e-8
        # angles are off by up to 2 mrad there, on arms of 0.15 m
        assert np.abs(told(e) - wanted).max() < 1e-3
        assert np.abs(fallen.theta - e["theta"]).max(axis=1).min() < 1e-9, "it was there"
    order = [e["event"] for e in ran.events if e["event"] in ("arrived", "phase", "summary")]
    assert order == ["phase", *2 * ["arrived"], *2 * ["phase"], "summary"]
    fallen.ends_at_rest(0)
    assert np.abs(fallen.theta[-1] - fallen.theta[0]).max() < 0.02, "it ends where it rested"
    assert fallen.speed.max() < 0.4


@pytest.mark.parametrize(
    ("pose", "why"),
    [
        ("0,0,900mm,0,0,0", "out of reach of axes 1, 2, 3, 4, 5, 6"),
        ("0,0,0.5,0,0,0", "axis 1: 0.56"),
        ("0,0,320mm,0,0,0", "allowed 0.28 to 0.315 ([[pose]])"),
        ("0,0,NaN,0,0,0", 'z is "NaN", no finite number'),
        ("0,0,310,0,0,0", "z is 310 m, allowed -10 to 10 m: without a unit it is in m"),
        ("0,0,0.3", "3 values: write the six x,y,z,rx,ry,rz"),
        ("0,0,30cm,0,0,0", 'unit "cm", must be one of m, mm, um'),
        ("0,0,0.3,0,0,5mm", 'unit "mm", must be one of rad, mrad, deg'),
    ],
)
def test_poses_that_cannot_be_taken_are_refused(
    pose: str, why: str, hexapod_ssp: Path, fmu_dir: Path, tmp_path: Path
) -> None:
    changes = [(FMU, str(fmu_dir / "pose.fmu")), POSE]
    bench = Bench(hexapod_ssp, tmp_path)
    ran = bench.run(command=(*MOVE, "--pose", pose), seconds=SHORT, changes=changes)
    assert ran.code == 2, ran.words
    assert why in ran.one("refused")["message"]
    assert not ran.happened("state"), "not one frame was sent"


def gap(height: float) -> float:
    """Straight up: what the rod of an arm is too short by [m], wherever the arm stands."""
    m, turn = read_machine(), np.linspace(-1.5, 1.5, 10_001)[:, None]
    ends = m.L * (m.u_B[0] * np.cos(turn) + np.cross(m.axis[0], m.u_B[0]) * np.sin(turn))
    v = m.r_EP[0] + [0, 0, height] - m.x_B[0]
    return float(np.linalg.norm(v - ends, axis=1).min() - m.l)


def test_last_pose_within_reach_is_named(hexapod_ssp: Path, fmu_dir: Path, tmp_path: Path) -> None:
    changes = [(FMU, str(fmu_dir / "pose.fmu"))]
    bench = Bench(hexapod_ssp, tmp_path)
    ran = bench.run(command=(*MOVE, "--pose", "0,0,900mm,0,0,0"), seconds=SHORT, changes=changes)
    found = re.search(r"x_E = \[0.00000, 0.00000, ([0-9.]+)\] m", ran.one("refused")["message"])
    assert found, "the way there from the neutral pose is straight up"
    height = float(found[1])
    # it looks at a hundred poses on the way
    assert gap(height) < 0 < gap(height + (0.9 - 0.3) / 100)


def test_pose_fmu_of_another_machine_is_refused(
    hexapod_ssp: Path, fmu_dir: Path, tmp_path: Path
) -> None:
    """By the kinematics of the system: nothing else would see it."""
    text = MACHINE_FILE.read_text()
    # both ends of an arm stand a millimetre farther out
    moved = text.replace("[0.15, -0.08, 0.0]", "[0.15, -0.081, 0.0]")
    moved = moved.replace("[0.15598076211353318, -0.210", "[0.15598076211353318, -0.211")
    assert moved != text
    other = tmp_path / "other.toml"
    other.write_text(moved)
    Source("pose", load_machine(other)).build_kept(tmp_path)
    bench = Bench(hexapod_ssp, tmp_path)
    for file, why in (
        (tmp_path / "pose.fmu", "build both from one machine file"),
        (fmu_dir / "reference.fmu", "it is not pose.fmu"),
        (tmp_path / "none.fmu", "cannot be read"),
    ):
        command = (*MOVE, "--pose", FIRST)
        ran = bench.run(command=command, seconds=SHORT, changes=[(FMU, str(file))])
        assert ran.code == 3, ran.words
        assert why in ran.one("refused")["message"]
        assert not ran.happened("state")


def test_jog_goes_to_a_pose_of_the_platform(
    hexapod_ssp: Path, fmu_dir: Path, tmp_path: Path
) -> None:
    changes = [(FMU, str(fmu_dir / "pose.fmu"))]
    lines = f"pose {FIRST}\npose 0,0,1\n3 0.01\nq\n"
    fallen = jogged(Bench(hexapod_ssp, tmp_path), lines, changes=changes)
    ran = fallen.ran
    assert ran.code == 0, ran.words
    arrived = [e for e in ran.events if e["event"] == "arrived"]
    assert len(arrived) == 3
    assert np.abs(told(arrived[1], "_ref") - WANTED[0]).max() < 1e-9
    assert np.subtract(arrived[2]["pose"], arrived[1]["pose"])[2] == pytest.approx(0.01)
    assert [e["line"] for e in ran.events if e["event"] == "not_done"] == ["pose 0,0,1"]
    fallen.ends_at_rest(0)

"""Robots' files with other parameters: MuJoCo reads the torques from them that were written."""

from __future__ import annotations

import re
from pathlib import Path

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.bases import base_of
from flexhex.diagnosis.basemodels.robots import RobotBase
from flexhex.diagnosis.kinds import LINEAR, ROTARY
from flexhex.diagnosis.logs import Log
from flexhex.diagnosis.machine_files.robot_write import write_robot
from flexhex.fmus.common.errors import MachineError
from tests.compare import assert_close
from tests.diagnosis.estimation.machines import CART
from tests.diagnosis.robots.simulated import FILE as ARM

pytest.importorskip("pinocchio", reason="the extra `robots` is not installed")
Array = NDArray[np.float64]


def base_for(file: Path, kinds: tuple[object, ...], joints: tuple[str, ...] = ()) -> RobotBase:
    n = len(kinds)
    log = Log.of("run.csv", 0.002, *np.zeros((2, 20, n)))
    base = base_of(str(file), None, log, joints=joints)
    assert isinstance(base, RobotBase)
    return base


def changed(base: RobotBase, share: float) -> dict[str, float]:
    """All bodies heavier, each by another factor; rotors, friction and damping."""
    values = {}
    for k, known in enumerate(base.linear):
        values[known.name] = known.nominal * (1 + share * (1 + k // 10) / base.n)
    for i, kind in enumerate(base.kinds, start=1):
        values |= {f"{kind.inertia}_r[{i}]": 0.1 * i, f"F_c[{i}]": 0.3 * i, f"d[{i}]": 0.02 * i}
    return values


def states(n: int) -> tuple[Array, Array, Array]:
    q, v, a = np.random.default_rng(1).standard_normal((3, 20, n))
    return q, v, a


def felt(file: Path, moved: tuple[Array, Array, Array]) -> Array:
    """MuJoCo's torques (samples, n) for a file, without friction, which it solves for."""
    model = mujoco.MjModel.from_xml_path(str(file))
    model.dof_frictionloss[:] = 0
    data, computed = mujoco.MjData(model), []
    for q, v, a in zip(*moved, strict=True):
        data.qpos[:], data.qvel[:], data.qacc[:] = q, v, a
        mujoco.mj_inverse(model, data)
        computed.append(data.qfrc_inverse.copy())
    return np.array(computed)


def torques(base: RobotBase, values: dict[str, float], moved: tuple[Array, Array, Array]) -> Array:
    p = np.array([values[known.name] for known in base.linear])
    d = np.array([values[f"d[{i + 1}]"] for i in range(base.n)])
    return np.asarray(base.columns(*moved) @ p + d * moved[1])


@pytest.mark.parametrize("share", [0.3, -0.6], ids=["heavier", "lighter than its fixed parts"])
def test_mujoco_reads_what_was_written_as_mjcf(share: float, tmp_path: Path) -> None:
    file, written = tmp_path / "cart.xml", tmp_path / "made.xml"
    file.write_text(CART)
    base = base_for(file, (LINEAR, ROTARY, ROTARY))
    values, moved = changed(base, share), states(3)
    left, scaled = write_robot(written, base, file, {**values, "o[2]": 0.3})
    assert left == ["o[2]"]
    assert bool(scaled) == (share < 0)
    assert all(part < 1 for part in scaled.values())
    wanted = torques(base, values, moved)
    assert_close(felt(written, moved), wanted, atol=1e-9 * np.abs(wanted).max())
    model = mujoco.MjModel.from_xml_path(str(written))
    assert_close(model.dof_frictionloss, np.array([0.3, 0.6, 0.9]), rtol=1e-15)
    assert (model.body_mass[1:] > 0).all()


def test_mujoco_reads_what_was_written_as_urdf(tmp_path: Path) -> None:
    written = tmp_path / "arm.urdf"
    base = base_for(ARM, (ROTARY,) * 6)
    values, moved = changed(base, 0.2), states(6)
    left, scaled = write_robot(written, base, ARM, values)
    assert not scaled
    assert left == [f"J_r[{i}]" for i in range(1, 7)]  # URDF has no place for rotors
    wanted = torques(base, {**values, **dict.fromkeys(left, 0.0)}, moved)
    assert_close(felt(written, moved), wanted, atol=1e-9 * np.abs(wanted).max())
    # as any file that is made here, no temporary one of its owner
    (tmp_path / "plain").touch()
    assert written.stat().st_mode == (tmp_path / "plain").stat().st_mode
    text = written.read_text()
    assert 'friction="0.3"' in text
    assert 'damping="0.12"' in text
    # what was not fitted stays: limits, and the mass of the tool on the flange
    assert text.count('effort="') == ARM.read_text().count('effort="')
    assert '<mass value="0.4"/>' in text


def test_only_numbers_differ_from_the_file(tmp_path: Path) -> None:
    file, written = tmp_path / "arm.urdf", tmp_path / "made.urdf"
    text = ARM.read_text()
    at = text.index("<robot")
    file.write_text(f"{text[:at]}<!-- by hand -->\n{text[at:]}")
    base = base_for(file, (ROTARY,) * 6)
    write_robot(written, base, file, {known.name: known.nominal for known in base.linear})
    one, other = file.read_text(), written.read_text()
    # a frame is not turned where nothing is said
    plain = [re.sub(r'"[^"]*"', "", text.replace(' rpy="0 0 0"', "")) for text in (one, other)]
    assert plain[1].splitlines()[1:-1] == plain[0].splitlines()[1:-1]
    assert "<!-- by hand -->\n<robot" in other
    # rounding leaves no lengths of a millionth of an atom
    numbers = re.findall(r"[-+]?[0-9.]+e-\d+", other)
    assert [own for own in numbers if abs(float(own)) < 1e-12] == []


def test_what_stands_on_locked_joints_stays_what_it_is(tmp_path: Path) -> None:
    written = tmp_path / "arm.urdf"
    base = base_for(ARM, (ROTARY,) * 2, ("j2", "j3"))
    write_robot(written, base, ARM, changed(base, 0.2))
    assert '<mass value="1.2"/>' in written.read_text()  # of link_5, behind locked j4 and j5
    again = base_for(written, (ROTARY,) * 2, ("j2", "j3"))
    wanted = [known.nominal * 1.2 for known in base.linear if known.name == "link_3.m"]
    listed = [known.nominal for known in again.linear if known.name == "link_3.m"]
    assert_close(np.array(listed), np.array(wanted), rtol=1e-12)


REFUSED = {
    "<compiler angle=": ('<compiler inertiafromgeom="true" angle=', "inertiafromgeom"),
    "<worldbody>": ('<include file="more.xml"/><worldbody>', "<include>"),
}


@pytest.mark.parametrize("old", REFUSED)
def test_files_whose_masses_come_from_elsewhere_are_refused(old: str, tmp_path: Path) -> None:
    file, written = tmp_path / "cart.xml", tmp_path / "made.xml"
    file.write_text(CART)
    base = base_for(file, (LINEAR, ROTARY, ROTARY))
    new, message = REFUSED[old]
    file.write_text(CART.replace(old, new))
    with pytest.raises(MachineError, match=message):
        write_robot(written, base, file, changed(base, 0.1))
    assert not written.exists()


def test_a_file_that_reads_back_otherwise_is_not_left(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    written = tmp_path / "arm.urdf"
    base = base_for(ARM, (ROTARY,) * 6)
    monkeypatch.setattr(
        "flexhex.diagnosis.machine_files.robot_write._number", lambda v: f"{float(v):.6g}"
    )
    with pytest.raises(MachineError, match="read back, it has other torques"):
        write_robot(written, base, ARM, changed(base, 0.2))
    assert list(tmp_path.iterdir()) == []

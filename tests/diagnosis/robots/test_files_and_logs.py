"""Joints in the order in which logs name them; moments of inertia of no body."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.bases import base_of
from flexhex.fmus.common.errors import UsageError
from tests.compare import assert_close
from tests.diagnosis.robots.simulated import FILE
from tests.diagnosis.robots.test_robots import log, motion

pytest.importorskip("pinocchio", reason="the extra `robots` is not installed")
Array = NDArray[np.float64]


def test_joints_of_a_file_are_in_the_order_in_which_logs_name_them() -> None:
    """ROS lists joints as they come, a file from the foot to the tool."""
    order, n = np.array([2, 0, 4, 1, 5, 3]), 6
    names = [f"j{k + 1}" for k in order]
    usual, moved = base_of(str(FILE), None, log(n)), motion(n)
    p = np.array([known.nominal for known in usual.linear])
    turned = replace(
        moved, **{k: getattr(moved, k)[:, order] for k in ("theta", "thetad", "thetadd")}
    )

    def named(*names: str, joints: tuple[str, ...] = ()) -> Array:
        said = replace(log(n), meta={"joints": ",".join(names)})
        base = base_of(str(FILE), None, said, joints=joints)
        return np.asarray(base.torque(turned, np.array([known.nominal for known in base.linear])))

    wanted = usual.torque(moved, p)[:, order]
    assert_close(named(*names), wanted, atol=1e-11)
    assert_close(named(joints=tuple(names)), wanted, atol=1e-11)
    # names of another robot say nothing
    for joints in (), tuple(f"j{k}" for k in range(1, 7)):
        assert_close(named(*"abcdef", joints=joints), usual.torque(turned, p), atol=1e-11)
    with pytest.raises(
        UsageError, match=r"^--joints: j1 is axis 1, where the logs name j3: leave this"
    ):
        named(*names, joints=tuple(f"j{k}" for k in range(1, 7)))


def test_names_of_another_file_are_told_with_the_axes_they_are_taken_for() -> None:
    for said, joints, told in (
        ("a,b,c,d,e,f", (), True),
        ("j1,j2,j3,j4,j5,f", (), True),
        ("j1,j2,j3,j4,j5,j6", (), False),
        ("a,b,c,d,e,f", tuple(f"j{k}" for k in range(1, 7)), False),
    ):
        base: Any = base_of(str(FILE), None, replace(log(6), meta={"joints": said}), joints=joints)
        assert any("are taken for j1, j2, j3, j4, j5, j6" in text for text in base.remarks) == told


@pytest.mark.parametrize(("iyy", "odd"), [("0.014", False), ("0.019", False), ("0.04", True)])
def test_moments_of_no_body_are_reported(iyy: str, odd: bool, tmp_path: Path) -> None:
    """Files from CAD have them often enough; torques can be calculated all the same."""
    (tmp_path / "arm.urdf").write_text(FILE.read_text().replace('iyy="0.014"', f'iyy="{iyy}"'))
    base: Any = base_of(str(tmp_path / "arm.urdf"), None, log(6))
    said = [text for text in base.remarks if "link_4" in text]
    assert bool(said) == odd
    assert all("largest is more than the sum of the others" in text for text in said)
    usual: Any = base_of(str(FILE), None, log(6))
    assert usual.remarks == ()

"""A neutral pose at which the lower arms do not hold the platform is refused."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from flexhex.fmus.common.errors import MachineError
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.machine_file import machine_data
from flexhex.fmus.common.model.geometry import WORST_CONDITION, Frames, platform_condition
from tests.conftest import MACHINE_FILE
from tests.oracles import geometry
from tests.oracles.machine import read_machine


def with_rods(lean: Any) -> Machine:
    """The default machine, its lower arms along lean(i) (3,) from their elbows up to E."""
    data = machine_data(MACHINE_FILE)
    length, L = data["geometry"]["l"]["value"], data["geometry"]["L"]["value"]
    x_E0 = np.array([0.0, 0.0, 0.4])
    data["geometry"]["x_E0"]["value"] = x_E0.tolist()
    for i, arm in enumerate(data["arms"]):
        rod = np.asarray(lean(i), dtype=float)
        elbow = np.array(arm["x_B"]["value"]) + L * np.array(arm["u_B"]["value"])
        tip = elbow + length * rod / np.linalg.norm(rod)
        arm["r_EP"]["value"] = (tip - x_E0).tolist()
    return Machine.model_validate(data)


def upright(i: int) -> list[float]:
    return [0.0, 0.0, 1.0]


def around(i: int) -> list[float]:
    """Rods that meet the vertical axis or are parallel to it: E may turn about it."""
    machine = read_machine()
    x, y = (np.array(machine.x_B[i]) + machine.L * np.array(machine.u_B[i]))[:2]
    return [-x, -y, 3.0 * math.hypot(x, y)]


@pytest.mark.parametrize("lean", [upright, around])
def test_singular_neutral_pose_is_refused(lean: Any) -> None:
    with pytest.raises(MachineError, match=r"mine\.toml: arms: the neutral pose is singular") as e:
        Frames.of(with_rods(lean), where="mine.toml")
    assert "correct x_B, r_EP, u_B or x_E0" in str(e.value)


def test_lean_that_just_holds_is_accepted() -> None:
    """Rods that lean to alternate sides by 10 degrees: condition of about ten."""
    spread = math.tan(math.radians(10))

    def lean(i: int) -> list[float]:
        side = spread if i % 2 else -spread
        angle = 2 * math.pi * (i // 2) / 3
        return [-side * math.sin(angle), side * math.cos(angle), 1.0]

    frames = Frames.of(with_rods(lean))
    assert 3 < platform_condition(frames.arms) < WORST_CONDITION


def test_condition_is_that_of_the_loops_own_rows() -> None:
    """Against the oracle's D_d: where E is moved, each rod's length changes by these rows."""
    subject, frames = read_machine(), Frames.of(Machine.model_validate(machine_data(MACHINE_FILE)))
    D_d = geometry.constraint_jacobian(subject, frames.x0)[:, 6:]
    s = math.sqrt(np.mean([arm.r_EP @ arm.r_EP for arm in frames.arms]))
    rows = []
    for i, arm in enumerate(frames.arms):
        # closure rows of arm i, columns of x_E and of the vector part of lam_E (twice the turn)
        block = D_d[5 * i + 2 : 5 * i + 5]
        along = arm.rod @ np.hstack([block[:, 24:27], block[:, 28:31] / 2 / s])
        rows.append(along)
    assert platform_condition(frames.arms) == pytest.approx(np.linalg.cond(rows), rel=1e-12)

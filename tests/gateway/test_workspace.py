"""Poses that the platform cannot take, or only near a singular one, are refused before power."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from tests.gateway.bench import Bench, Ran
from tests.gateway.test_falls import POSE
from tests.gateway.test_jog import jogged
from tests.gateway.test_refusals import REST_RAD
from tests.oracles.calculus import Array
from tests.oracles.geometry import close, dependent_rates, neutral
from tests.oracles.machine import Machine, read_machine

MOVE = ("move", "--enable", "--lockstep", "--hold", 0.2)
ONE_UP, TWO_UP = (-1, 1, 1, 1, 1, -1), (-1, -1, 1, -1, -1, 1)
"""Signs of angles that lead to a singular pose, at 0.35 and at 0.5 rad: within the limits."""
STEP_RAD = 0.005
"""The gateway judges poses at most so far apart."""


def written(pose: Array) -> str:
    """A pose on the command line."""
    return ",".join(f"{angle:.17g}" for angle in pose)


def moved(ssp: Path, folder: Path, pose: Array, *changes: tuple[str, str]) -> Ran:
    """A move to a pose."""
    command = (*MOVE, "--to", written(pose))
    return Bench(ssp, folder).run(command=command, changes=changes)


def refusal(ran: Ran) -> str:
    """Why a pose is not taken; not one frame was sent."""
    assert ran.code == 2, ran.words
    assert not ran.happened("state")
    return str(ran.one("refused")["message"])


def gain(machine: Machine, x: Array) -> float:
    """Largest motion of the platform for an angle of an axis, over that in the neutral pose."""

    def sizes(x: Array) -> Array:
        J = dependent_rates(machine, x)
        position = np.linalg.norm(J[30:33], axis=0).max()
        return np.array([position, 2 * np.linalg.norm(J[33:37], axis=0).max()])

    return float((sizes(x) / sizes(neutral(machine))).max())


@pytest.mark.parametrize("signs", [ONE_UP, TWO_UP])
def test_way_ends_where_an_independent_model_comes_near_a_singular_pose(
    signs: tuple[int, ...], hexapod_ssp: Path, tmp_path: Path
) -> None:
    """The angle at which the gain first exceeds 2, derived anew from the machine file."""
    message = refusal(moved(hexapod_ssp, tmp_path, 0.51 * np.array(signs)))
    assert "allowed 2 (landing.platform_gain): a singular pose is near" in message
    at = np.array(json.loads(re.search(r"\[.*?\]", message)[0]))  # type: ignore[index]
    assert np.array_equal(np.sign(at), signs)
    machine, size = read_machine(), float(np.abs(at).max())
    assert np.abs(at).min() == size < 0.51
    # the message has three digits
    far, near = size + 1e-3, size - STEP_RAD - 1e-3
    assert gain(machine, close(machine, far * np.array(signs))) > 2.0
    assert gain(machine, close(machine, near * np.array(signs))) < 2.0


def test_gain_that_is_allowed_decides(hexapod_ssp: Path, tmp_path: Path) -> None:
    """All axes up together: the gain of the independent model, on its two sides."""
    pose, machine = np.full(6, 0.2), read_machine()
    there = gain(machine, close(machine, pose))
    for most, code in ((there + 0.01, 0), (there - 0.01, 2)):
        change = ("torque_N_m = 6.0 ", f"platform_gain = {most}\ntorque_N_m = 6.0 ")
        assert moved(hexapod_ssp, tmp_path, pose, change).code == code


def test_limits_of_the_pose_hold_in_a_move(hexapod_ssp: Path, tmp_path: Path) -> None:
    machine = read_machine()
    message = refusal(moved(hexapod_ssp, tmp_path, np.full(6, 0.2), POSE))
    at, value = re.search(r"(\[.*?\]).*x\.x_E\.z = ([\d.]+), allowed 0.28", message).groups()  # type: ignore[union-attr]
    x = close(machine, np.array(json.loads(at)))
    assert float(value) == pytest.approx(x[32], abs=1e-3)
    assert x[32] + 1e-3 > 0.315


def test_way_of_the_landing_is_judged_too(hexapod_ssp: Path, tmp_path: Path) -> None:
    """Both poses have a gain of 1.96, and the way between them has 2.09."""
    rest, pose = (-0.23, 0.33, 0.43, 0.23, 0.33, -0.43), (-0.43, 0.33, 0.23, 0.43, 0.33, -0.23)
    machine, middle = read_machine(), np.add(rest, pose) / 2
    gains = [gain(machine, close(machine, np.array(at))) for at in (rest, pose, middle)]
    assert max(gains[:2]) < 2.0 < gains[2]
    allowed = ("torque_N_m = 6.0 ", "platform_gain = 2\ntorque_N_m = 6.0 ")
    rests = (REST_RAD, f"rest_rad = {list(rest)}")
    command = (*MOVE, "--to", written(np.zeros(6)))
    for more, changes, code in (
        (("--to", written(np.array(pose))), (allowed,), 0),
        # by the drives: the machine does not rest there
        ((), (allowed, rests), 1),
        (("--to", written(np.array(pose))), (allowed, rests), 2),
    ):
        ran = Bench(hexapod_ssp, tmp_path).run(command=(*command, *more), changes=changes)
        assert ran.code == code, ran.words
    assert "allowed 2 (landing.platform_gain)" in refusal(ran)


def test_jog_refuses_the_step_and_goes_on(hexapod_ssp: Path, tmp_path: Path) -> None:
    """A way to a singular pose is no order; the next line is one, and the machine lands."""
    lines = f"to {written(0.51 * np.array(TWO_UP))}\n3 0.05\nq\n"
    fallen = jogged(Bench(hexapod_ssp, tmp_path), lines)
    assert fallen.ran.code == 0, fallen.ran.words
    assert "a singular pose is near" in fallen.ran.words
    assert np.abs(fallen.theta - [0, 0, 0.05, 0, 0, 0]).max(axis=1).min() < 1e-3
    assert fallen.theta.max() < 0.06, "it did not set out"
    fallen.ends_at_rest(0)

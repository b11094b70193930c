"""Inverse kinematics: the inverse of the forward kinematics, with rates; what is out of reach.

The oracles close the loops numerically and know nothing of fmus; the kinematics block is N itself.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from tests.blocks.loaded import Loaded, load, machine
from tests.compare import assert_close
from tests.oracles import geometry
from tests.oracles.calculus import Array
from tests.oracles.machine import Machine, read_machine
from tests.oracles.motions import random_motion

STROKE = machine().geometry.stroke
NAMES = ("x_E", "lam_E", "xd_E", "lamd_E", "xdd_E", "lamdd_E")
REACH, TURN = 0.06, np.radians(8)
"""Workspace of the tests about neutral: every coordinate of position [m] and rotation [rad]."""


@cache
def subject() -> Machine:
    return read_machine()


def started(block: str = "pose", **parameters: float) -> Loaded:
    loaded = load(block)
    loaded.start(**parameters)
    return loaded


def inputs(x: Array, xd: Array, xdd: Array, length: float = 1.0) -> dict[str, Array]:
    """Inputs of the block from x~ and its rates (37,), with a quaternion of that length."""
    parts = [part for v in (x, xd, xdd) for part in (v[30:33], length * v[33:])]
    return dict(zip(NAMES, parts, strict=True))


def random_pose(rng: np.random.Generator) -> tuple[Array, Array]:
    """x_E (3,), lam_E (4,) in the workspace."""
    x_E = np.array(machine().platform.x_E0) + rng.uniform(-REACH, REACH, 3)
    phi = rng.uniform(-TURN, TURN, 3)
    angle = np.linalg.norm(phi)
    return x_E, np.append(np.cos(angle / 2), np.sin(angle / 2) * phi / angle)


def path(t: float) -> dict[str, Array]:
    """A brisk motion about neutral with the exact rates; lam_E leaves the unit sphere."""
    rng, w = np.random.default_rng(2), 2 * np.pi * np.array([1.1, 0.9, 1.3, 0.7, 1.0, 1.2, 0.8])
    at = np.append(np.array(machine().platform.x_E0), [1.0, 0.0, 0.0, 0.0])
    size = np.append(np.full(3, 0.02), np.full(4, 0.05)) * rng.uniform(0.5, 1, 7)
    values = at + size * np.sin(w * t)
    rates, accelerations = size * w * np.cos(w * t), -size * w**2 * np.sin(w * t)
    parts = [part for v in (values, rates, accelerations) for part in (v[:3], v[3:])]
    return dict(zip(NAMES, parts, strict=True))


@pytest.mark.parametrize("seed", range(20))
def test_pose_is_the_inverse_of_the_kinematics(seed: int) -> None:
    """The oracle takes theta, thetad, thetadd to the pose, the block takes it back."""
    motion = random_motion(seed)
    y = started().tick(**inputs(*geometry.motion(subject(), *motion), length=1.7))
    assert y["fault"] == 0.0
    # the oracle's Taylor circle leaves 1e-12 of rates, its square of accelerations
    for name, expected, atol in zip(("r", "rd", "rdd"), motion, (1e-12, 1e-11, 1e-9), strict=True):
        assert_close(y[name], expected, atol=atol, what=name)


def test_kinematics_gives_the_wanted_pose_back_across_the_workspace() -> None:
    """With the stroke widened: one in forty of these poses turns a motor beyond it."""
    rng, pose, kinematics = np.random.default_rng(4), started(stroke=1.5), started("kinematics")
    for _ in range(1000):
        x_E, lam_E = random_pose(rng)
        rates = {name: rng.normal(0, 0.5, len(x_E)) for name in ("xd_E", "xdd_E")}
        # a rate of lam_E that keeps its length
        turn = np.append(0.0, rng.normal(0, 0.5, 3))
        lamd_E = geometry.multiply(lam_E, turn)
        lamdd_E = geometry.multiply(lamd_E, turn)
        y = pose.tick(x_E=x_E, lam_E=lam_E, lamd_E=lamd_E, lamdd_E=lamdd_E, **rates)
        assert y["fault"] == 0.0
        back = kinematics.tick(theta=y["r"], thetad=y["rd"], thetadd=y["rdd"])
        assert back["converged"] == 1.0
        sign = np.sign(back["x"][33:] @ lam_E)
        for name, wanted, d in (("x", x_E, lam_E), ("xd", rates["xd_E"], lamd_E)):
            assert_close(back[name][30:33], wanted, atol=1e-10, what=name)
            assert_close(sign * back[name][33:], d, atol=1e-10, what=name)
        assert_close(back["xdd"][30:33], rates["xdd_E"], atol=1e-9, what="xdd")
        assert_close(sign * back["xdd"][33:], lamdd_E, atol=1e-9, what="xdd")


def test_pose_rates_are_derivatives() -> None:
    """Central differences of r along a path whose quaternion has no fixed length."""
    block, h = started(), 1e-4
    for t in np.linspace(0, 1, 50):
        before, at, after = (dict_of(block, t + k * h) for k in (-1, 0, 1))
        # h^2 / 6 of a third derivative of 500 rad/s3; rounding 1e-16 / h^2
        rate = (after["r"] - before["r"]) / (2 * h)
        assert_close(at["rd"], rate, atol=1e-5, what="rd")
        acceleration = (after["rd"] - before["rd"]) / (2 * h)
        assert_close(at["rdd"], acceleration, atol=1e-4, what="rdd")
        assert np.abs(at["rdd"]).max() > 1e-2


def dict_of(block: Loaded, t: float) -> dict[str, Array]:
    """r, rd, rdd on the path, copied."""
    y = block.tick(**path(t))
    return {name: y[name] for name in ("r", "rd", "rdd")}


def test_pose_keeps_the_assembly_of_the_machine() -> None:
    """Of the two angles of an arm the one that goes on from neutral; the other is far off."""
    rng, pose, kinematics, solved = np.random.default_rng(7), started(), started("kinematics"), 0
    for _ in range(200):
        theta = rng.uniform(-0.95, 0.95, 6) * STROKE
        followed = kinematics.tick(theta=theta)
        if followed["converged"]:
            x, solved = followed["x"], solved + 1
            assert_close(pose.tick(x_E=x[30:33], lam_E=x[33:])["r"], theta, atol=1e-12, what="r")
    assert solved > 180


@pytest.mark.parametrize(
    ("wanted", "arms"),
    [
        ({"x_E": [0.0, 0.0, 3.0]}, [0] * 6),  # no arm is so long
        ({"x_E": [0.0, 0.0, 0.6]}, [0] * 6),  # the arms reach it beyond their stroke
        ({"x_E": [0.2, 0.0, 0.3]}, None),  # some arms only
        ({"lam_E": [0.0, 0.0, 0.0, 0.0]}, [0] * 6),  # no orientation
        ({"xd_E": [1e4, 1e4, 1e4], "x_E": [10.0, 10.0, 10.0]}, [0] * 6),
    ],
)
def test_pose_flags_what_is_out_of_reach_and_recovers(
    wanted: dict[str, list[float]], arms: list[int] | None
) -> None:
    block = started()
    good = block.tick(**path(0.3)).values.copy()
    last = block.y["r"]
    y = block.tick(**wanted)
    assert y["fault"] == 2.0
    assert 0 in y["reachable"]
    if arms is None:
        assert 1 in y["reachable"]
    else:
        assert list(y["reachable"]) == arms
    assert np.array_equal(y["r"], last)
    assert not y["rd"].any()
    assert not y["rdd"].any()
    assert np.isfinite(y.values).all()
    assert np.array_equal(block.tick(**path(0.3)).values, good)


def test_pose_stays_finite_up_to_the_dead_point() -> None:
    """Upwards along z until the arms do not reach: no step of r that the rates do not explain."""
    block, h, last = started(stroke=1.5), 1e-4, None
    for z in np.arange(0.3, 0.8, h):
        y = block.tick(x_E=[0.0, 0.0, z], xd_E=[0.0, 0.0, 1.0])
        assert np.isfinite(y.values).all()
        if y["fault"]:
            break
        if last is not None:
            rate = np.maximum(np.abs(last[1]), np.abs(y["rd"]))
            assert (np.abs(y["r"] - last[0]) <= 1.1 * h * rate).all()
        last = y["r"], y["rd"]
    assert y["fault"] == 2.0
    assert last is not None


def test_pose_starts_at_the_neutral_pose() -> None:
    y = started().tick()
    assert_close(y["r"], np.zeros(6), atol=1e-15, what="r")
    assert not y["rd"].any()
    assert y["reachable"].all()

"""N: equal to a NumPy twin of (28), (29), (15) to (17), (30); holds and recovers.

The twin takes D, D_x and closure from the oracles, which know nothing of fmus.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from tests.blocks.loaded import Loaded, StartError, load
from tests.compare import assert_close
from tests.oracles import actuator, geometry
from tests.oracles.bridge import same_quaternions
from tests.oracles.calculus import Array, taylor
from tests.oracles.machine import Machine, read_machine
from tests.sampling import draw

TS, SIGMA = 0.0005, 0.015
UNREACHABLE = np.array([-0.6, 0.0, 0.0, 0.0, 0.6, -0.6])


@cache
def subject() -> Machine:
    return read_machine()


def started(**parameters: float) -> Loaded:
    block = load("kinematics")
    block.start(**parameters)
    return block


def swing(t: float, amplitude: float = 0.15) -> tuple[Array, Array, Array]:
    """theta, thetad, thetadd (6,) of a brisk smooth motion that begins at rest at neutral."""
    w = 2 * np.pi * np.array([1.1, 0.9, 1.3, 0.7, 1.0, 1.2])
    sign = np.array([1, -1, 1, 1, -1, -1]) * amplitude / 2
    return (
        sign * (1 - np.cos(w * t)),
        sign * w * np.sin(w * t),
        sign * w * w * np.cos(w * t),
    )


class Twin:
    """Prediction, one dense correction, rates by the implicit function theorem."""

    def __init__(self, x0: Array) -> None:
        self.d = x0[6:].copy()
        self.dd, self.ddd = np.zeros(31), np.zeros(31)
        self.z: Array = np.zeros(6)
        self.last: Array | None = None

    def tick(self, theta: Array, thetad: Array, thetadd: Array) -> dict[str, Array]:
        if self.last is not None:
            self.z = actuator.dahl(self.z, theta - self.last, SIGMA)
        self.last = theta
        x = np.concatenate([theta, self.d + self.dd * TS + self.ddd * TS**2 / 2])
        D_d = geometry.constraint_jacobian(subject(), x)[:, 6:]
        x[6:] -= np.linalg.solve(D_d, geometry.constraints(subject(), x))
        xd = geometry.dependent_rates(subject(), x) @ thetad
        D_x = geometry.constraint_jacobian(subject(), x)
        line = taylor(lambda s: geometry.constraints(subject(), x + s[:, None] * xd), 2, 0.5)
        curvature = 2 * line[2].real
        ddd = -np.linalg.solve(D_x[:, 6:], D_x[:, :6] @ thetadd + curvature)
        self.d, self.dd, self.ddd = x[6:], xd[6:], ddd
        return {"x": x, "xd": xd, "xdd": np.concatenate([thetadd, ddd]), "z": self.z}


def test_kinematics_equals_its_twin() -> None:
    block = started()
    twin = Twin(block.y["x"])
    # rounding of a 31 x 31 solve, condition 10: 1e-14 of rates up to 2/s and 12/s2
    atol = {"x": 1e-14, "xd": 1e-13, "xdd": 1e-12, "z": 1e-14}
    for k in range(400):
        motion = swing(TS * k)
        expected = twin.tick(*motion)
        y = block.tick(theta=motion[0], thetad=motion[1], thetadd=motion[2])
        for name, allowed in atol.items():
            assert_close(y[name], expected[name], atol=allowed, what=f"{name}, tick {k}")


def test_kinematics_keeps_the_loops_closed_with_one_correction() -> None:
    """[SH, IV-E] promises |D| < 1e-9; here that leaves rounding, over 4 s at 1 Hz."""
    block, largest = started(), 0.0
    for k in range(8000):
        theta, thetad, thetadd = swing(TS * k)
        y = block.tick(theta=theta, thetad=thetad, thetadd=thetadd)
        assert y["converged"] == 1.0
        largest = max(largest, y["residual"])
    assert 0 < largest < 1e-14


@pytest.mark.parametrize("at", [0.2, 0.55, 0.9])
def test_kinematics_rates_are_derivatives_of_the_closure(at: float) -> None:
    theta, thetad, thetadd = swing(at)
    y = started().tick(theta=theta, thetad=thetad, thetadd=thetadd)
    sign = np.where(y["x"] * geometry.close(subject(), theta) < 0, -1.0, 1.0)
    expected = geometry.motion(subject(), theta, thetad, thetadd)
    for name, part in zip(("x", "xd", "xdd"), expected, strict=True):
        # 1e-14 of rates up to 2/s over the radius of the oracle's Taylor circle, squared
        assert_close(y[name], part * sign, atol=1e-12, what=name)


def test_kinematics_corrections_square_the_residual() -> None:
    """10 urad of noise on theta is far from smooth: one correction leaves 1e-9, two rounding."""
    rng = np.random.default_rng(5)
    noisy = [(swing(TS * k)[0] + rng.normal(0, 1e-5, 6), *swing(TS * k)[1:]) for k in range(500)]
    largest = {}
    for corrections in (1, 2):
        block = started(corrections=corrections)
        residuals = [block.tick(theta=a, thetad=b, thetadd=c)["residual"] for a, b, c in noisy]
        largest[corrections] = max(residuals)
    assert 1e-11 < largest[1] < 1e-8
    assert largest[2] < 1e-14


def test_kinematics_follows_jumps_to_the_right_assembly() -> None:
    """Loops of this kind close in several ways; a jump must not land in another one and stay.

    Over the whole stroke one pose in a hundred is out of reach: there it says so.
    """
    places = list(np.random.default_rng(1).uniform(-0.52, 0.52, (250, 6)))
    block, lost = started(), 0
    for theta in draw(places, 60, "jumps of the kinematics"):
        y = block.tick(theta=theta)
        if y["converged"] == 0.0:
            lost += 1
            continue
        expected = same_quaternions(geometry.close(subject(), theta), y["x"])
        assert_close(y["x"], expected, atol=1e-12, what="x")
    assert lost < 10


@pytest.mark.parametrize(
    ("last", "theta"),
    [
        ([-0.33, 0.35, -0.27, 0.34, -0.52, -0.46], [-0.46, 0.45, 0.33, -0.51, 0.45, -0.29]),
        ([0.51, -0.47, -0.41, 0.27, -0.21, 0.51], [0.5, -0.25, -0.28, 0.23, 0.38, 0.35]),
    ],
)
def test_kinematics_far_jump_is_solved_from_neutral(last: list[float], theta: list[float]) -> None:
    """Newton's method from the last good pose ends in another assembly here."""
    block = started()
    block.tick(theta=last)
    x = block.tick(theta=theta)["x"]
    expected = same_quaternions(geometry.close(subject(), np.array(theta)), x)
    assert_close(x, expected, atol=1e-12, what="x")


def test_kinematics_residual_is_the_norm_of_all_constraints() -> None:
    """Far from closed, so that every row of D counts: one correction after 0.1 rad."""
    block = started(tolerance=1e-2)
    block.tick(theta=np.zeros(6))
    y = block.tick(theta=np.array([0.1, -0.1, 0.08, -0.05, 0.1, -0.1]))
    D = geometry.constraints(subject(), y["x"])
    assert np.abs(D[30]) > 1e-6
    assert_close(y["residual"], np.linalg.norm(D), atol=1e-15, what="residual")


def test_kinematics_holds_the_last_good_pose_and_recovers() -> None:
    block = started()
    for k in range(50):
        theta, thetad, thetadd = swing(TS * k)
        good = block.tick(theta=theta, thetad=thetad, thetadd=thetadd)["x"]
    for _ in range(3):
        y = block.tick(theta=UNREACHABLE, thetad=np.full(6, 2.0), thetadd=np.full(6, 9.0))
        assert (y["converged"], y["fault"]) == (0.0, 2.0)
        assert 1e-6 < y["residual"] < np.inf
        assert np.array_equal(y["x"], good)
        assert not y["xd"].any()
        assert not y["xdd"].any()
    # the hysteresis went along with the angle
    moved = UNREACHABLE != 0
    assert_close(y["z"][moved], np.sign(UNREACHABLE[moved]), atol=1e-9, what="z")
    y = block.tick(theta=theta, thetad=thetad, thetadd=thetadd)
    assert (y["converged"], y["fault"]) == (1.0, 0.0)
    assert_close(y["x"], good, atol=1e-12, what="x")
    assert np.array_equal(y["xd"][:6], thetad)


def test_kinematics_starts_anywhere_without_history() -> None:
    theta = np.array([0.2, -0.25, 0.3, 0.1, -0.3, 0.15])
    y = started().tick(theta=theta)
    assert y["converged"] == 1.0
    expected = same_quaternions(geometry.close(subject(), theta), y["x"])
    assert_close(y["x"], expected, atol=1e-14, what="x")
    assert not y["z"].any()


def test_kinematics_starts_unreachable_and_recovers() -> None:
    block = started()
    neutral = block.y["x"]
    y = block.tick(theta=UNREACHABLE)
    assert y["converged"] == 0.0
    assert np.array_equal(y["x"], neutral)
    # no pose yet: z waits, though the angles move
    y = block.tick(theta=0.99 * UNREACHABLE)
    assert y["converged"] == 0.0
    assert not y["z"].any()
    y = block.tick(theta=np.zeros(6))
    assert y["converged"] == 1.0
    assert not y["z"].any()
    assert block.tick(theta=np.full(6, 0.01))["z"].all()


def test_kinematics_tracks_hysteresis_exactly_over_large_steps() -> None:
    rng, block = np.random.default_rng(3), started()
    z, last = np.zeros(6), np.zeros(6)
    block.tick(theta=last)
    for _ in range(200):
        theta = rng.uniform(-0.2, 0.2, 6)
        z = actuator.dahl(z, theta - last, SIGMA)
        y, last = block.tick(theta=theta), theta
        assert_close(y["z"], z, atol=1e-14, what="z")


def test_kinematics_state_is_all_there_is() -> None:
    block = started()
    for k in range(20):
        block.tick(theta=swing(TS * k)[0])
    kept, outputs = block.state.copy(), block.y.values.copy()
    first = block.tick(theta=swing(0.3)[0]).values.copy()
    block.state[:], block.y.values[:] = kept, outputs
    assert np.array_equal(block.tick(theta=swing(0.3)[0]).values, first)


def test_kinematics_refuses_half_a_correction() -> None:
    with pytest.raises(StartError, match=r"^corrections = 1.5, must be a whole number$"):
        started(corrections=1.5)

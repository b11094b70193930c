"""The oracles against each other, before anything of ours is held against them."""

from __future__ import annotations

import ast
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.compare import assert_close
from tests.oracles import actuator, geometry, lagrange
from tests.oracles.calculus import gradient, taylor
from tests.oracles.kalman import Kalman
from tests.oracles.machine import Machine
from tests.oracles.motions import random_bodies, random_motion
from tests.oracles.mujoco_tree import MujocoTree
from tests.oracles.parameters import base_parameters


def test_oracles_import_nothing_of_ours() -> None:
    """Only test files and fixtures, whose task it is to compare, may see the project."""
    foreign = {"fmus", "fmugen", "ssp", "flexhex", "diagnosis"}
    for path in sorted(Path(__file__).parent.glob("*.py")):
        if path.name.startswith(("test_", "conftest")):
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom):
                names = [node.module or ""]
            else:
                names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            seen = {name.split(".")[0] for name in names} & foreign
            assert not seen, f"{path.name} imports {seen}"


def test_taylor_finds_known_coefficients() -> None:
    """exp(2 s) = 1 + 2 s + 2 s^2 + ...; rounding 1e-16 over the radius squared."""
    assert_close(np.real(taylor(lambda s: np.exp(2 * s), 2)), [1.0, 2.0, 2.0], atol=1e-12)
    slope = gradient(lambda x: x[..., 0] ** 2 * np.sin(x[..., 1]), np.array([3.0, 0.5]))
    assert_close(slope, [6 * np.sin(0.5), 9 * np.cos(0.5)], atol=1e-13)


def test_rotation_is_the_usual_one() -> None:
    rng = np.random.default_rng(1)
    R = Rotation.random(5, rng=rng)
    lam = geometry.quaternion(R.as_matrix())
    assert_close(geometry.rotation(lam), R.as_matrix(), atol=1e-15)
    assert_close(geometry.rotation(3 * lam), 9 * R.as_matrix(), atol=1e-14, what="scaled")
    product = geometry.multiply(lam[0], lam[1])
    assert_close(geometry.rotation(product), (R[0] * R[1]).as_matrix(), atol=1e-15)


def test_neutral_pose_closes_free_of_stress(machine: Machine) -> None:
    x0 = geometry.neutral(machine)
    assert_close(geometry.constraints(machine, x0), np.zeros(31), atol=1e-15)
    assert_close(np.stack(geometry.deformations(machine, x0)), np.zeros((2, 6, 3)), atol=1e-15)


def test_jacobian_agrees_with_complex_step(machine: Machine) -> None:
    """Away from |lam| = 1 too, where a homogeneous and a normalised rotation differ."""
    x = geometry.close(machine, random_motion(1)[0]) + np.linspace(-0.1, 0.1, 37)
    columns = [geometry.constraints(machine, x + 1e-30j * e).imag / 1e-30 for e in np.eye(37)]
    D_x = geometry.constraint_jacobian(machine, x)
    assert_close(D_x, np.array(columns).T, atol=1e-14, what="D_x")


@pytest.mark.parametrize("seed", range(3))
def test_motion_agrees_with_implicit_differentiation(machine: Machine, seed: int) -> None:
    """Taylor coefficients of the closure against [SH, Eq. (14) to (17)]."""
    theta, thetad, thetadd = random_motion(seed)
    x, xd, xdd = geometry.motion(machine, theta, thetad, thetadd)
    J, D_x = geometry.dependent_rates(machine, x), geometry.constraint_jacobian(machine, x)
    line = taylor(lambda s: geometry.constraints(machine, x + s[:, None] * xd), 2)
    curvature = 2 * line[2].real
    gamma = np.concatenate([np.zeros(6), -np.linalg.solve(D_x[:, 6:], curvature)])
    assert_close(geometry.constraints(machine, x), np.zeros(31), atol=3e-15, what="D")
    assert_close(xd, J @ thetad, atol=3e-14, what="xd")
    # rounding over the radius squared: 1e-16 (17 / 0.25)^2
    assert_close(xdd, J @ thetadd + gamma, atol=3e-12, what="xdd")


def test_circle_is_neither_too_wide_nor_too_coarse(machine: Machine) -> None:
    """Half the radius and twice the points give the same accelerations."""
    theta, thetad, thetadd = random_motion(4)

    def acceleration(factor: float, points: int) -> np.ndarray:
        radius, _ = geometry.circle(thetad, thetadd)
        path = taylor(
            lambda s: geometry.close(
                machine, theta + s[:, None] * thetad + s[:, None] ** 2 / 2 * thetadd
            ),
            2,
            radius * factor,
            points,
        )
        return 2 * path[2].real

    usual = geometry.motion(machine, theta, thetad, thetadd)[2]
    assert_close(acceleration(0.5, 32), usual, atol=5e-12)
    assert_close(acceleration(1.0, 64), usual, atol=5e-12)


@pytest.mark.parametrize("seed", [None, 7, 8])
def test_lagrange_agrees_with_mujoco(machine: Machine, seed: int | None) -> None:
    """Two derivations without a common line; 1e-12 is 1e-13 of the torque."""
    subject = machine if seed is None else random_bodies(machine, seed)
    motion = random_motion(seed or 0)
    tau = lagrange.inertial_torque(subject, *motion) + lagrange.gravity_torque(subject, motion[0])
    assert np.max(np.abs(tau)) > 2, "the motion is meant to be brisk"
    assert_close(MujocoTree(subject).inverse_dynamics(*motion), tau, atol=1e-12, what="tau")


def test_mujoco_jacobians_agree_with_closure(machine: Machine) -> None:
    """The null space of MuJoCo's own Jacobians carries the closure's velocities."""
    tree, (theta, thetad, thetadd) = MujocoTree(machine), random_motion(2)
    qpos, qvel, _ = tree.state(theta, thetad, thetadd)
    assert_close(tree.projection(qpos) @ thetad, qvel, atol=3e-14, what="qvel")


def test_base_parameters_leave_the_torque(machine: Machine) -> None:
    """Masses moved from the rod's ends to the neighbours change neither p nor the torque."""
    start = random_bodies(machine, 3)
    at_Q, at_P = 0.17, 0.08
    rod, ends = np.array([start.l, 0, 0]), np.array([start.L, 0, 0])
    platform = start.end_effector
    for r in start.r_EP:
        platform = platform.with_point(at_P, r)
    lower = start.lower.with_point(-at_Q, np.zeros(3)).with_point(-at_P, rod)
    moved = replace(
        start, lower=lower, upper=start.upper.with_point(at_Q, ends), end_effector=platform
    )
    assert abs(moved.end_effector.m - start.end_effector.m) > 0.4, "masses did move"
    assert_close(base_parameters(moved), base_parameters(start), atol=1e-14, what="p")
    motion = random_motion(3)
    tau = lagrange.torque(start, *motion)
    assert_close(lagrange.torque(moved, *motion), tau, atol=1e-12, what="tau")
    assert base_parameters(machine).shape == (162,)


def test_dahl_step_solves_its_equation() -> None:
    for z, step in ((0.3, 0.004), (0.3, -0.004), (-0.9, 0.05), (0.99, -0.03)):
        exact = actuator.dahl(np.array(z), np.array(step), 0.015)
        assert_close(exact, actuator.dahl_by_integration(z, step, 0.015), atol=1e-10)
    assert_close(actuator.dahl(np.array([0.4]), np.zeros(1), 0.015), [0.4], what="at rest")


def test_chi_is_linear_in_its_basis(machine: Machine) -> None:
    """(22) by hand from the unfiltered columns of chi_f."""
    act, (theta, thetad, _) = machine.actuator, random_motion(5)
    z = np.linspace(-1, 1, 6)
    columns = actuator.basis(act.omega, 9, theta, z).reshape(6, 19)
    pairs = np.stack([act.a, act.b], axis=-1).reshape(6, 18)
    weights = np.concatenate([act.c[:, None], pairs], axis=1)
    expected = act.o + act.k * theta + act.d * thetad + np.sum(weights * columns, axis=1)
    assert_close(actuator.chi(act, theta, thetad, z), expected, atol=1e-15)


def test_filter_delays_and_differentiates() -> None:
    """A parabola: the window delays by 50.5 samples, stencils by one, and both signs hold."""
    Ts = 0.0005
    taps = actuator.hann(101)
    assert_close(np.sum(taps), 1.0, atol=1e-15, what="DC gain")
    assert_close(taps @ np.arange(101), 50.5, atol=1e-13, what="delay")
    t = Ts * np.arange(200)
    smooth = actuator.filtered(3 + 2 * t + 5 * t * t, taps)
    value, rate, acceleration = actuator.derivatives(smooth, Ts)
    middle = t[101:-1] - 50.5 * Ts
    assert_close(rate, 2 + 10 * middle, atol=1e-10, what="first derivative")
    assert_close(acceleration, np.full(98, 10.0), atol=1e-7, what="second derivative")
    spread = 5 * (taps @ (Ts * (np.arange(101) - 50.5)) ** 2)
    assert_close(value, 3 + 2 * middle + 5 * middle**2 + spread, atol=1e-13, what="value")


def test_kalman_without_drift_is_regularised_least_squares() -> None:
    rng = np.random.default_rng(2)
    n, s, p0 = 5, rng.uniform(0.5, 2, 5), rng.normal(size=5)
    adapting = np.array([1.0, 1.0, 0.0, 1.0, 1.0])
    kalman = Kalman(p0, s, 0.3, np.zeros(n), 1e-2, adapting)
    data = [(rng.normal(size=(3, n)), rng.normal(size=3)) for _ in range(20)]
    for Phi, tau in data:
        p, P = kalman.step(Phi, tau)
    on = adapting > 0
    H = np.vstack([Phi for Phi, _ in data]) * s
    tau = np.concatenate([tau for _, tau in data]) - H @ (p0 / s)
    information = np.eye(4) / 0.3 + H[:, on].T @ H[:, on] / 1e-2
    q = np.linalg.solve(information, H[:, on].T @ tau / 1e-2)
    assert_close((p / s - p0 / s)[on], q, atol=1e-12, what="q")
    assert_close(P[np.ix_(on, on)], np.linalg.inv(information), atol=1e-14, what="P")
    assert_close(p[2], p0[2], what="frozen parameter")
    assert_close(P[2], np.zeros(n), what="frozen covariance")


def test_kalman_predicts_drift_before_it_corrects() -> None:
    """One parameter by hand: P = P0 + R1, then P R2 / (P + R2)."""
    kalman = Kalman(np.array([2.0]), np.array([2.0]), 1.0, np.array([0.5]), 0.25, np.ones(1))
    p, P = kalman.step(np.array([[0.5]]), np.array([3.0]))
    assert_close(P, [[1.5 * 0.25 / 1.75]], atol=1e-15, what="P")
    assert_close(p, [2 * (1 + 1.5 / 1.75 * 2.0)], atol=1e-14, what="p")

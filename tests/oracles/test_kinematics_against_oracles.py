"""Closure, Newton step and rates of fmus.common against the oracles.

Tolerances: the oracle's x is good to 1e-15 and, by rounding over the radius of its Taylor
circle, its rates to 1e-14 of 3 rad/s and its accelerations to 1e-12 beside 200 rad/s2.
"""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from flexhex.fmus.common.model.model import Model
from tests.common.dense_form import DenseForm
from tests.compare import assert_close
from tests.oracles import geometry
from tests.oracles.bridge import Paths, compiled, same_quaternions
from tests.oracles.calculus import taylor
from tests.oracles.machine import Machine
from tests.oracles.motions import random_motion

SEEDS = range(3)


@pytest.fixture(scope="module")
def dense(model: Model) -> DenseForm:
    return DenseForm.of(model.machine)


def test_neutral_pose_is_the_oracles(machine: Machine, model: Model) -> None:
    expected = same_quaternions(geometry.neutral(machine), model.frames.x0)
    assert_close(model.frames.x0, expected, atol=1e-15, what="x0")


@pytest.mark.parametrize("seed", SEEDS)
def test_constraints_equal_the_oracles(
    machine: Machine, model: Model, dense: DenseForm, path: Paths, seed: int
) -> None:
    """Off the constraints too: both forms are the same polynomials of x."""
    noise = np.random.default_rng(seed).uniform(-0.1, 0.1, 37)
    x = path(seed)[0] + noise
    D = geometry.constraints(machine, x)
    assert np.max(np.abs(D)) > 0.01
    assert_close(np.array(dense.residual(x)).ravel(), D, atol=1e-14, what="dense D")
    structured = compiled([37], lambda s: model.linkage(s).residual())
    assert_close(structured(x), D, atol=1e-14, what="structured D")


@pytest.mark.parametrize("seed", SEEDS)
def test_jacobian_and_curvature_equal_the_oracles(
    machine: Machine, model: Model, dense: DenseForm, path: Paths, seed: int
) -> None:
    """D_x by complex step; sum D_xx xd xd of (17) by the Taylor coefficient along xd."""
    rng = np.random.default_rng(seed)
    x = path(seed)[0] + rng.uniform(-0.1, 0.1, 37)
    xd = rng.uniform(-1, 1, 37)
    D_x = np.array(
        [geometry.constraints(machine, x + 1e-30j * e).imag / 1e-30 for e in np.eye(37)]
    ).T
    assert_close(np.array(dense.jacobian(x)), D_x, atol=1e-14, what="D_x")

    line = taylor(lambda s: geometry.constraints(machine, x + s[:, None] * xd), 2, 0.5)
    curvature = 2 * line[2].real
    v = [ca.SX.sym("x", 37), ca.SX.sym("xd", 37), ca.SX.sym("xdd", 37)]
    linkage = model.linkage(v[0])
    rates = ca.Function("rates", v, [linkage.accelerations(v[1], v[2][:6])])
    xdd = np.array(rates(x, xd, np.zeros(37))).ravel()
    assert_close(D_x[:, 6:] @ xdd[6:], -curvature, atol=1e-13, what="D_xx xd xd")


@pytest.mark.parametrize("seed", SEEDS)
def test_newton_step_is_the_exact_one(
    machine: Machine, model: Model, path: Paths, seed: int
) -> None:
    """The structured step equals the dense solve on the oracle's D and D_d, far from closed."""
    noise = np.random.default_rng(seed).uniform(-0.05, 0.05, 37)
    x = path(seed)[0] + noise
    D_d = geometry.constraint_jacobian(machine, x)[:, 6:]
    expected = x[6:] - np.linalg.solve(D_d, geometry.constraints(machine, x))
    newton = compiled([37], lambda s: model.linkage(s).newton())
    assert_close(newton(x), expected, atol=1e-13, what="d after one step")


@pytest.mark.parametrize("seed", SEEDS)
def test_newton_closes_where_the_oracle_does(machine: Machine, model: Model, seed: int) -> None:
    newton = compiled([37], lambda s: model.linkage(s).newton())
    theta = random_motion(seed)[0]
    x = np.concatenate([theta, model.frames.x0[6:]])
    for _ in range(8):
        x[6:] = newton(x)
    expected = geometry.close(machine, theta)
    assert_close(x, same_quaternions(expected, x), atol=2e-15, what="x")


@pytest.mark.parametrize("seed", SEEDS)
def test_rates_equal_derivatives_of_the_closure(
    model: Model, dense: DenseForm, path: Paths, seed: int
) -> None:
    _, thetad, thetadd = random_motion(seed)
    x, xd, xdd = path(seed)
    rates = compiled([37, 6], lambda s, v: model.linkage(s).rates(v))
    accelerations = compiled([37, 37, 6], lambda s, v, a: model.linkage(s).accelerations(v, a))
    assert_close(rates(x, thetad), xd, atol=3e-14, what="xd")
    assert_close(accelerations(x, xd, thetadd), xdd, atol=3e-12, what="xdd")
    dense_xd, dense_xdd = (np.array(v).ravel() for v in dense.rates(x, thetad, thetadd))
    assert_close(dense_xd, xd, atol=3e-14, what="dense xd")
    assert_close(dense_xdd, xdd, atol=3e-12, what="dense xdd")

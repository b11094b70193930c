"""Torques, parameters and regressor of fmus.common against the oracles.

Tolerances: the oracles agree to 1e-14 of a torque with each other (test_oracles.py), so
1e-12 N m beside 15 N m is rounding and anything above is an error.
"""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from flexhex.fmus.common import actuator as common_actuator
from flexhex.fmus.common.model.bodies import Mechanism
from flexhex.fmus.common.model.dynamics import loads, project
from flexhex.fmus.common.model.model import Model
from flexhex.fmus.common.model.parameters import base_parameters
from tests.compare import assert_close
from tests.oracles import actuator, lagrange, parameters
from tests.oracles.bridge import Numeric, Paths, chi_of, compiled, z_of
from tests.oracles.machine import Machine
from tests.oracles.motions import random_bodies, random_motion
from tests.oracles.mujoco_tree import MujocoTree

SEEDS = range(3)


def test_actuator_basis_and_dahl_equal_the_oracles(machine: Machine, model: Model) -> None:
    """Angle addition against cosines of multiples; steps up to ten sigma, and none."""
    theta, z = random_motion(0)[0], z_of(0)
    basis = compiled([6, 6], model.basis)(theta, z)
    assert_close(basis, chi_of(machine, theta, z), atol=2e-14, what="basis")
    steps = machine.actuator.sigma * np.array([0.0, 1e-3, -0.3, 2.5, -10.0, 10.0])
    dahl = compiled([6, 6], lambda s, d: common_actuator.dahl(s, d, machine.actuator.sigma))
    expected = actuator.dahl(z, steps, machine.actuator.sigma)
    assert_close(dahl(z, steps), expected, atol=1e-15, what="z")


def test_nominal_parameters_are_the_oracles(machine: Machine, model: Model) -> None:
    p = base_parameters(model.machine)
    assert_close(p, parameters.base_parameters(machine), atol=1e-15, what="p")


@pytest.mark.sample(1)
@pytest.mark.parametrize("seed", SEEDS)
def test_inverse_dynamics_agrees_with_mujoco(
    machine: Machine, model: Model, path: Paths, torque: Numeric, seed: int
) -> None:
    """All of (24): MuJoCo for inertia and weight, energy for flexures, (22) by hand."""
    theta, thetad, thetadd = random_motion(seed)
    z = z_of(seed)
    tau = MujocoTree(machine).inverse_dynamics(theta, thetad, thetadd)
    tau = tau + lagrange.elastic_torque(machine, theta)
    tau = tau + actuator.chi(machine.actuator, theta, thetad, z)
    motion = path(seed)
    mine = torque(*motion, chi_of(machine, theta, z), base_parameters(model.machine))
    assert np.max(np.abs(tau)) > 2, "the motion is meant to be brisk"
    assert_close(mine, tau, atol=1e-12, what="tau")


@pytest.mark.sample(1)
@pytest.mark.parametrize("seed", range(20, 23))
def test_inverse_dynamics_agrees_with_lagrange_for_any_bodies(
    machine: Machine, path: Paths, torque: Numeric, seed: int
) -> None:
    """Bodies without symmetry: every inertial and elastic parameter counts, each its own way."""
    subject = random_bodies(machine, seed)
    p = parameters.base_parameters(subject)
    p[:132] = 0.0
    motion = path(seed)
    expected = lagrange.torque(subject, *random_motion(seed))
    assert_close(torque(*motion, np.zeros(114), p), expected, atol=2e-12, what="tau")


@pytest.mark.sample(1)
@pytest.mark.parametrize("seed", range(30, 32))
def test_full_mechanism_agrees_with_lagrange(
    machine: Machine, model: Model, path: Paths, seed: int
) -> None:
    """The plant's form, with the lower arm's own mass and with a payload."""
    subject = random_bodies(machine, seed).with_payload(0.7)
    par = parameters.full_mechanism(subject)

    def tau(x: ca.SX, xd: ca.SX, xdd: ca.SX, v: ca.SX) -> ca.SX:
        linkage = model.linkage(x)
        return project(linkage, loads(linkage, model.motion(xd, xdd), Mechanism.split(v, 6)))

    motion = path(seed)
    mine = compiled([37, 37, 37, len(par)], tau)(*motion, par)
    assert_close(mine, lagrange.torque(subject, *random_motion(seed)), atol=2e-12, what="tau")


@pytest.mark.sample(1)
@pytest.mark.parametrize("seed", SEEDS)
def test_flexures_hold_with_the_gradient_of_their_energy(
    machine: Machine, path: Paths, torque: Numeric, seed: int
) -> None:
    """Each stiffness alone, at rest and without weights; the sign is that of (24)."""
    theta = random_motion(seed)[0]
    x, zero = path(seed)[0], np.zeros(37)
    for k in range(4):
        p = np.zeros(162)
        p[158 + k] = 1.0
        k_u, k_s = p[158:160], p[160:162]
        alone = Machine(**{**vars(machine), "k_u": k_u, "k_s": k_s})
        expected = lagrange.elastic_torque(alone, theta)
        mine = torque(x, zero, zero, np.zeros(114), p)
        assert_close(mine, expected, atol=1e-13, what=f"torque of stiffness {k}")


@pytest.mark.sample(1)
@pytest.mark.parametrize("seed", SEEDS)
def test_regressor_times_parameters_is_the_torque(
    machine: Machine, path: Paths, torque: Numeric, regressor: Numeric, seed: int
) -> None:
    motion = path(seed)
    chi = chi_of(machine, motion[0][:6], z_of(seed))
    p = np.random.default_rng(seed).normal(size=162)
    Phi = regressor(*motion, chi)
    assert Phi.shape == (6, 162)
    assert_close(Phi @ p, torque(*motion, chi, p), rtol=1e-13, what="Phi p")


def test_regressor_has_full_rank_on_rich_motion(
    machine: Machine, path: Paths, regressor: Numeric
) -> None:
    """162 by singular values of unit columns; the smallest stands far above rounding."""
    rows = []
    for seed in range(100, 130):
        motion = path(seed)
        rows.append(regressor(*motion, chi_of(machine, motion[0][:6], z_of(seed))))
    stacked = np.vstack(rows)
    size = np.linalg.norm(stacked, axis=0)
    assert np.min(size) > 0, f"column {np.argmin(size)} is empty"
    stacked = stacked / size
    values = np.linalg.svd(stacked, compute_uv=False)
    assert values[-1] > 1e-6 * values[0], f"smallest {values[-1]:.3g}, largest {values[0]:.3g}"
    tied = np.column_stack([stacked, stacked @ np.ones(162)])
    assert np.linalg.svd(tied, compute_uv=False)[-1] < 1e-12, "a redundant column is seen"

"""The plant's forward dynamics against the oracles, and its energy.

Tolerances: torques of the oracle are good to 1e-13 of 10 N m; the smallest inertia that a
joint feels is about 0.05 kg m2, so accelerations are good to 1e-11 of 100 rad/s2.
"""

from __future__ import annotations

from collections.abc import Callable

import casadi as ca
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from flexhex.fmus.common.model.model import Model
from flexhex.fmus.plant.equations import functions
from tests.compare import assert_close
from tests.oracles import actuator, geometry, lagrange, parameters
from tests.oracles.bridge import Array, Paths, z_of
from tests.oracles.machine import Machine
from tests.oracles.motions import random_bodies, random_motion

Plant = dict[str, ca.Function]


@pytest.fixture(scope="module")
def plant(model: Model) -> Plant:
    return {f.name(): f for f in functions(model.machine)}


def values(result: ca.DM) -> Array:
    return np.array(result).ravel()


@pytest.mark.sample(1)
@pytest.mark.parametrize("seed", range(40, 43))
def test_plant_accelerates_as_lagrange_says(
    machine: Machine, plant: Plant, path: Paths, seed: int
) -> None:
    """Torque for a chosen acceleration from energies and (22); the plant gives it back.

    Bodies without symmetry, all actuator terms and a payload.
    """
    theta, thetad, thetadd = random_motion(seed)
    subject, payload, z = random_bodies(machine, seed), 0.7, z_of(seed)
    tau = lagrange.torque(subject.with_payload(payload), theta, thetad, thetadd)
    tau = tau + actuator.chi(machine.actuator, theta, thetad, z)
    x, xd, _ = path(seed)
    mechanism = parameters.full_mechanism(subject)
    p = parameters.base_parameters(machine)[:132]
    rates = plant["plant_rates"](theta, thetad, x[6:], z, mechanism, p, payload)
    actual = np.array(rates[0]) @ np.append(tau, 1.0)
    assert_close(actual, thetadd, atol=1e-10, what="thetadd")
    assert_close(values(rates[1]), xd[6:], atol=3e-14, what="dd")
    slope = thetad / machine.actuator.sigma * (1 - np.sign(thetad) * z)
    assert_close(values(rates[2]), slope, rtol=1e-15, what="zd")


def test_plant_closes_and_shows_its_pose(machine: Machine, plant: Plant, path: Paths) -> None:
    x = path(44)[0]
    d = values(plant["plant_neutral"]()["d"])
    for _ in range(8):
        d, before = (values(v) for v in plant["plant_close"](x[:6], d))
    assert_close(d, x[6:], atol=2e-15, what="d")
    assert_close(before, [0.0], atol=5e-15, what="residual")
    off = d + np.linspace(-0.01, 0.01, 31)
    norm = np.linalg.norm(geometry.constraints(machine, np.concatenate([x[:6], off])))
    assert_close(values(plant["plant_close"](x[:6], off)[1]), [norm], atol=1e-15, what="residual")
    x_E, phi_E = (values(v) for v in plant["plant_pose"](d))
    assert_close(x_E, x[30:33], atol=2e-15, what="x_E")
    turned = Rotation.from_quat(x[33:], scalar_first=True).as_rotvec()
    assert_close(phi_E, turned, atol=2e-14, what="phi_E")


def runge_kutta(slope: Callable[[Array], Array], y: Array, h: float) -> Array:
    """One step of the classical fourth-order method."""
    k1 = slope(y)
    k2 = slope(y + h / 2 * k1)
    k3 = slope(y + h / 2 * k2)
    return y + h / 6 * (k1 + 2 * k2 + 2 * k3 + slope(y + h * k3))


def test_undamped_plant_conserves_energy(machine: Machine, plant: Plant) -> None:
    """Held against its weight by constant torques, it trades motion for height and bending.

    The energy is the oracle's. Runge-Kutta at 1 ms loses 1e-12 J; 1e-10 is allowed.
    """
    subject = machine.with_payload(0.5)
    gravity = lagrange.gravity_torque(subject, np.zeros(6))
    mechanism, none = parameters.full_mechanism(machine), np.zeros(132)
    d = values(plant["plant_neutral"]()["d"])

    def close(theta: Array) -> Array:
        for _ in range(4):
            d[:] = values(plant["plant_close"](theta, d)[0])
        return d

    def slope(y: Array) -> Array:
        state = (y[:6], y[6:], close(y[:6]), np.zeros(6), mechanism, none, 0.5)
        response = np.array(plant["plant_rates"](*state)[0])
        return np.concatenate([y[6:], response @ np.append(gravity, 1.0)])

    def energy(y: Array) -> tuple[float, float]:
        x = np.concatenate([y[:6], close(y[:6])])
        T = lagrange.kinetic_energy(subject, x, geometry.dependent_rates(subject, x) @ y[6:])
        V = lagrange.gravity_energy(subject, x) + lagrange.elastic_energy(subject, x)
        return float(T), float(T + V - gravity @ y[:6])

    y, kinetic = np.concatenate([np.zeros(6), np.linspace(-0.6, 0.9, 6)]), []
    start = energy(y)[1]
    for _ in range(300):
        y = runge_kutta(slope, y, 1e-3)
        T, total = energy(y)
        kinetic.append(T)
        assert_close(total, start, atol=1e-10, what="energy")
    assert max(kinetic) > 1.5 * min(kinetic), "energy is exchanged"
    assert np.max(np.abs(y[:6])) < 0.5, "within the stroke"

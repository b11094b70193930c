"""One sign for all: plant, regressor and feedforward agree about every effect of the library."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import casadi as ca
import numpy as np
import pytest

from flexhex.fmus.common.effects import library
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.machine_file import load_machine
from flexhex.fmus.common.model.effect_bank import Bank, columns_function, compensated
from flexhex.fmus.common.model.model import Model
from flexhex.fmus.common.model.parameters import base_parameters, parameters
from flexhex.fmus.estimator.equations import functions as estimator_functions
from flexhex.fmus.feedforward.equations import functions as feedforward_functions
from flexhex.fmus.plant.equations import functions as plant_functions
from tests.blocks.loaded import machine
from tests.blocks.motions import Instant, random_instants
from tests.compare import assert_close
from tests.conftest import MACHINE_FILE
from tests.effects.machines import Array, axis_of, everything, on_axes, only, use, with_effects

COMPENSATED = [id for id in on_axes() if compensated(library()[id])]
LOSING = [id for id in COMPENSATED if library()[id].acts_on == "drive"] + ["cross_coupling"]
ROUNDING = 1e-9
"""N m: rounding of the loops' closure (1e-12 rad) and of the accelerations."""


def instants(seed: int) -> list[Instant]:
    """Fast and slow ones: some effects show at low rates alone."""
    return [*random_instants(2, seed), *random_instants(2, seed + 100, brisk=0.02)]


def called(function: ca.Function, *arguments: object) -> list[Array]:
    """Results of a CasADi function as flat arrays."""
    results = function.call([ca.DM(np.asarray(a, dtype=float)) for a in arguments])
    return [np.array(result).ravel() for result in results]


@cache
def plant(subject: Machine) -> dict[str, ca.Function]:
    return {f.name(): f for f in plant_functions(subject)}


class Point:
    """A random state of the plant with drives that are busy."""

    def __init__(self, bank: Bank, at: Instant, seed: int) -> None:
        rng = np.random.default_rng(seed)
        self.at, self.theta, self.thetad = at, at.x[:6], at.xd[:6]
        self.tau, self.taud = rng.uniform(-5, 5, 6), rng.uniform(-50, 50, 6)
        self.time, self.payload = rng.uniform(0.5, 20), 0.0
        self.state = rng.uniform(-0.5, 0.5, bank.n_states)

    def signals(self, thetadd: Array) -> Array:
        """As `instant` of effect_bank takes them (31,)."""
        rows = (self.theta, self.thetad, thetadd, self.tau, self.taud, [self.time])
        return np.concatenate(rows)

    def accelerations(self, subject: Machine, effect: Array, joint: Array) -> Array:
        """thetadd (6,) of the plant, `joint` being what leaves the drives' lags."""
        from flexhex.fmus.plant.interface import parameters as plant_parameters

        fixed = {v.name: v.starts for v in plant_parameters(subject)}
        arguments = [self.theta, self.thetad, self.at.x[6:], self.at.z]
        arguments += [np.array(fixed["mechanism"]), np.array(fixed["actuator"]), self.payload]
        arguments += [self.tau, self.taud, self.time, self.state, effect]
        response = called(plant(subject)["plant_rates"], *arguments)[0].reshape(6, 7)
        return np.asarray(response @ np.append(joint, 1.0))


@cache
def packed_regressor(subject: Machine) -> Callable[..., Array]:
    """Dense Phi from the estimator's own functions."""
    regressor, columns = estimator_functions(subject)
    (places,) = called(columns)
    n_p, width = len(parameters(subject)), len(places) // 6

    def dense(*arguments: object) -> Array:
        (phi,) = called(regressor, *arguments)
        Phi = np.zeros((6, n_p))
        for k, value in enumerate(phi):
            Phi[k // width, int(places[k])] += value
        return Phi

    return dense


def rates_along(subject: Machine, at: Instant, thetadd: Array) -> Array:
    """xdd (37,) at a pose for other accelerations of the joints."""
    model = Model(subject)
    x, xd, joint = ca.SX.sym("x", 37), ca.SX.sym("xd", 37), ca.SX.sym("thetadd", 6)
    xdd = model.linkage(x).accelerations(xd, joint)
    return called(ca.Function("along", [x, xd, joint], [xdd]), at.x, at.xd, thetadd)[0]


def regressed(subject: Machine, point: Point, thetadd: Array, p: Array) -> Array:
    """Phi p (6,) [N m] at a point of a motion with these accelerations."""
    model, bank = Model(subject), Bank.compensated(subject)
    theta, z = ca.SX.sym("theta", 6), ca.SX.sym("z", 6)
    (chi,) = called(
        ca.Function("chi", [theta, z], [model.basis(theta, z)]), point.theta, point.at.z
    )
    (columns,) = called(columns_function(bank, "c"), point.signals(thetadd), known_state(point))
    xdd = rates_along(subject, point.at, thetadd)
    Phi = packed_regressor(subject)(point.at.x, point.at.xd, xdd, [*chi, *columns])
    return np.asarray(Phi @ p)


def known_state(point: Point) -> Array:
    """States of the compensated effects; in `everything` no other one has any."""
    return point.state


@pytest.mark.sample(6)
@pytest.mark.parametrize("id", COMPENSATED)
def test_plant_and_regressor_agree(id: str) -> None:
    """Phi p = tau at random states of the plant, with and without the effect."""
    subject = everything()
    real, known = Bank.all(subject), Bank.compensated(subject)
    effect, part = only(real, id), library()[id]
    p = np.concatenate([base_parameters(machine()), only(known, id)])
    noticed = 0.0
    for k, at in enumerate(instants(21)):
        point = Point(real, at, seed=k)
        lost = effect.sum() * point.taud * (np.arange(6) == use(id).axes[0] - 1)
        joint = point.tau - lost if part.line else point.tau
        thetadd = point.accelerations(subject, effect, joint)
        tau = regressed(subject, point, thetadd, p)
        assert_close(tau, point.tau, atol=ROUNDING, what=f"{id}: Phi p")
        without = regressed(subject, point, thetadd, np.where(np.arange(len(p)) < 162, p, 0))
        noticed = max(noticed, float(np.abs(without - point.tau).max()))
    assert noticed > 1e-4, "the effect is not there"


@pytest.mark.sample(6)
@pytest.mark.parametrize("id", COMPENSATED)
def test_feedforward_and_regressor_agree(id: str) -> None:
    """F's torque is Phi p at that torque.

    A loss is solved by four steps, each of which leaves less than a quarter (saturation; its slope
    is s (2 |tau| - tau_k) = 0.025 (2 * 6 - 2)).
    """
    subject, bank = everything(), Bank.compensated(everything())
    torque, whole, *_ = feedforward_functions(subject)
    gains = only(bank, id)
    p, noticed = np.concatenate([base_parameters(machine()), gains]), 0.0
    for k, at in enumerate(instants(22)):
        point = Point(bank, at, seed=k)
        (base,) = called(torque, at.x, at.xd, at.xdd, at.z, p)
        point.tau = base
        (tau,) = called(whole, point.signals(at.xdd[:6]), point.state, p)
        point.tau = tau
        expected = regressed(subject, point, at.xdd[:6], p)
        left = 0.25**4 * np.abs(tau - base).max() if id in LOSING else 0.0
        assert_close(tau, expected, atol=ROUNDING + left, what=id)
        noticed = max(noticed, float(np.abs(tau - base).max()))
    assert noticed > 1e-4


def test_feedforward_without_gains_is_the_models() -> None:
    subject, bank = everything(), Bank.compensated(everything())
    _, whole, *_ = feedforward_functions(subject)
    p = np.concatenate([base_parameters(machine()), np.zeros(bank.n_gains)])
    for k, at in enumerate(instants(23)):
        point = Point(bank, at, seed=k)
        (tau,) = called(whole, point.signals(at.xdd[:6]), point.state, p)
        assert np.array_equal(tau, point.tau)


def test_plant_solves_for_columns_of_the_acceleration() -> None:
    """An inertia shared between two axes: the mass matrix is then not symmetric any more."""
    entry = use("cross_coupling", source=5.0, kind=2.0, C=0.02)
    subject = with_effects(entry)
    p = base_parameters(subject)
    for k, at in enumerate(random_instants(3, seed=24)):
        point = Point(Bank.all(subject), at, seed=k)
        thetadd = point.accelerations(subject, np.array([0.02]), point.tau)
        tau = regressed(subject, point, thetadd, p)
        assert_close(tau, point.tau, atol=ROUNDING, what="Phi p")
        nothing = point.accelerations(subject, np.zeros(1), point.tau)
        assert np.abs(nothing - thetadd).max() > 1e-3


def test_tilted_base_is_gravity_turned_back() -> None:
    """Plant and feedforward feel g of a base that is turned by +0.1 rad about x, then y."""
    tilted = with_effects(use("gravity_tilt", tilt_x=0.1, tilt_y=-0.2))
    g = np.array(machine().gravity.g)
    a, b = 0.1, -0.2
    about_x = np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])
    about_y = np.array([[np.cos(b), 0, np.sin(b)], [0, 1, 0], [-np.sin(b), 0, np.cos(b)]])
    expected = (about_y @ about_x).T @ g
    felt = np.array(ca.DM(Model(tilted).g)).ravel()
    assert_close(felt, expected, atol=1e-14, what="g")
    slanted, tilt = np.array([1.0, 2.0, -9.0]), library()["gravity_tilt"]
    turned_back = tilt.mechanism(ca.SX(slanted), {"tilt_x": a, "tilt_y": b})
    what = "of any direction"
    assert_close(ca.DM(turned_back), ((about_y @ about_x).T @ slanted)[:, None], 1e-14, what=what)
    turned = machine().gravity.model_copy(update={"g": tuple(float(v) for v in expected)})
    other = machine().model_copy(update={"gravity": turned})
    (at,) = random_instants(1, seed=25)
    p = base_parameters(machine())
    mine, theirs = (
        called(feedforward_functions(m)[0], at.x, at.xd, at.xdd, at.z, p)[0]
        for m in (tilted, other)
    )
    assert_close(mine, theirs, atol=1e-12, what="tau_ff")


def test_actuators_alone_have_their_effects_too() -> None:
    """Without a platform p is shorter, and the gains stand behind it all the same."""
    alone = load_machine(MACHINE_FILE.with_name("tflex-actuators.toml"))
    subject = alone.model_copy(update={"effects": (use("cubic_stiffness", k_3=2.0),)})
    p, theta = base_parameters(subject), np.full(6, 0.2)
    assert len(p) == len(base_parameters(alone)) + 1
    axis, zero = axis_of("cubic_stiffness") - 1, np.zeros(6)
    torque, whole, *_ = feedforward_functions(subject)
    (base,) = called(torque, theta, zero, zero, zero, p)
    now = np.concatenate([theta, zero, zero, base, zero, [0.0]])
    (tau,) = called(whole, now, np.zeros(1), p)
    assert_close(tau - base, 2.0 * 0.2**3 * (np.arange(6) == axis), atol=1e-14, what="tau_ff")

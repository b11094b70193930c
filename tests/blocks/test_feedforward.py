"""F: equal to its CasADi function and to Lagrange's equations; holds what it cannot compute."""

from __future__ import annotations

import numpy as np
import pytest

from flexhex.fmus.common.model.parameters import base_parameters, parameters
from flexhex.fmus.feedforward.equations import functions
from tests.blocks.loaded import Array, Loaded, load, machine
from tests.blocks.motions import Instant, random_instants
from tests.compare import assert_close
from tests.oracles import actuator, lagrange
from tests.oracles.machine import read_machine


def started() -> Loaded:
    block = load("feedforward")
    block.start()
    return block


def torque(block: Loaded, at: Instant, p: Array) -> Array:
    """tau_ff (6,) [N m] of one tick."""
    tau: Array = block.tick(x=at.x, xd=at.xd, xdd=at.xdd, z=at.z, p=p)["tau_ff"]
    return tau


def test_feedforward_equals_its_function() -> None:
    (function,), p, block = functions(machine()), base_parameters(machine()), started()
    for at in random_instants(50, seed=1):
        expected = np.array(function(*at, p)).ravel()
        # the same operations in the same order; a compiler may only change the last bit
        assert_close(torque(block, at, p), expected, rtol=1e-14, what="tau_ff")
        assert block.y["fault"] == 0.0


@pytest.mark.sample(1)
@pytest.mark.parametrize("seed", range(3))
def test_feedforward_is_what_lagrange_asks_for(seed: int) -> None:
    subject, p = read_machine(), base_parameters(machine())
    (at,) = random_instants(1, seed=seed, brisk=2.0)
    theta, thetad, thetadd = at.x[:6], at.xd[:6], at.xdd[:6]
    expected = lagrange.torque(subject, theta, thetad, thetadd)
    expected = expected + actuator.chi(subject.actuator, theta, thetad, at.z)
    # the kinematics closes to 1e-12, the oracle is good to 1e-12 of 10 N m
    assert_close(torque(started(), at, p), expected, atol=1e-10, what="tau_ff")


def test_feedforward_uses_every_parameter_and_is_linear_in_them() -> None:
    block, p = started(), base_parameters(machine())
    instants = list(random_instants(8, seed=2))
    whole = np.array([torque(block, at, p) for at in instants])
    parts = np.zeros_like(whole)
    for k, par in enumerate(parameters(machine())):
        one = np.zeros_like(p)
        one[k] = 1.0
        part = np.array([torque(block, at, one) for at in instants])
        assert np.abs(part).max() > 1e-4, f"{par.name} has no effect"
        parts += p[k] * part
    assert_close(parts, whole, atol=1e-12, what="sum over the parameters")


def test_feedforward_holds_the_last_torque_and_recovers() -> None:
    p, block = base_parameters(machine()), started()
    good, other = random_instants(2, seed=3)
    last = torque(block, good, p)
    # no pose: quaternions of length zero
    nothing = Instant(np.zeros(37), *good[1:])
    for _ in range(2):
        assert np.array_equal(torque(block, nothing, p), last)
        assert block.y["fault"] == 2.0
    assert np.abs(torque(block, other, p) - last).max() > 0.1
    assert block.y["fault"] == 0.0


def test_feedforward_begins_with_no_torque() -> None:
    assert not load("feedforward").start()["tau_ff"].any()

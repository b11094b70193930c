"""The blocks in C with effects: nothing changes at zero gains; lags and delays exact."""

from __future__ import annotations

import importlib
from functools import cache

import numpy as np
import pytest

from flexhex.fmugen.blocks import BLOCKS, block_interface
from flexhex.fmus.common.model.effect_bank import Bank
from flexhex.fmus.common.model.parameters import base_parameters
from tests.blocks.loaded import Loaded, StartError, load, machine
from tests.blocks.motions import Instant
from tests.blocks.plant_twin import EXACT, torques
from tests.blocks.test_filter import TS
from tests.compare import assert_close
from tests.effects.machines import Array, axis_of, everything, only

BASE = 0.00025
CHANGED = ("plant", "filter", "feedforward")


@cache
def real() -> Bank:
    return Bank.all(everything())


@cache
def known() -> Bank:
    return Bank.compensated(everything())


def plant(gains: Array, **parameters: object) -> Loaded:
    block = load("plant", everything())
    block.start(effect=gains, **{**EXACT, **parameters})
    return block


def one(id: str, value: float) -> Array:
    """Gains of the plant, zero but for the only one of an effect."""
    return np.where(only(real(), id) != 0, value, 0.0)


def angles(block: Loaded, commands: Array) -> Array:
    return np.array([block.tick(tau=tau)["theta"] for tau in commands])


@pytest.mark.parametrize("block", BLOCKS)
def test_machine_without_effects_has_none_of_their_c(block: str) -> None:
    """Neither sizes nor functions: what effects.h and step.c have for them is left out."""
    module = importlib.import_module(f"flexhex.fmus.{block}.equations")
    for subject, wanted in ((machine(), False), (everything(), block in CHANGED)):
        names = [function.name() for function in module.functions(subject)]
        constants = block_interface(block, subject).constants
        assert any("effect" in name for name in names) == wanted
        assert ("N_EFFECT" in constants) == wanted


def test_plant_without_gains_is_the_nominal_plant() -> None:
    """With effects it takes Runge-Kutta steps throughout, so the nominal one does here too."""
    nominal = load("plant", flags=("-DPLANT_CLASSICAL",))
    subject = plant(np.zeros(real().n_gains))
    nominal.start(**EXACT)
    for tau in torques(300, seed=31):
        expected, actual = nominal.tick(tau=tau, payload=0.3), subject.tick(tau=tau, payload=0.3)
        assert np.array_equal(actual.values, expected.values)


def test_feedforward_without_gains_is_the_nominal_one() -> None:
    nominal, subject = load("feedforward"), load("feedforward", everything())
    nominal.start()
    subject.start()
    p = base_parameters(machine())
    for at in along(40):
        given = {"x": at.x, "xd": at.xd, "xdd": at.xdd, "z": at.z}
        expected = nominal.tick(p=p, **given)["tau_ff"]
        actual = subject.tick(p=np.concatenate([p, np.zeros(known().n_gains)]), **given)["tau_ff"]
        assert np.array_equal(actual, expected)


def test_lag_and_current_loop_can_be_exchanged() -> None:
    """Two lags in a row: which of them is the drive's does not matter to the joint."""
    commands = torques(300, seed=32)
    axis = axis_of("drive_lag") - 1
    slow, fast = 150.0, 700.0
    moved = []
    for f, lag in ((slow, fast), (fast, slow)):
        block = plant(one("drive_lag", 1 / (2 * np.pi * lag)), f_current=f)
        mask = np.arange(6) == axis
        # the other axes are at rest without a command: only the lagged one differs by f
        moved.append(angles(block, np.where(mask, commands, 0.0)))
    assert_close(moved[0], moved[1], atol=1e-13, what="theta")
    plain = plant(np.zeros(real().n_gains), f_current=slow)
    without = angles(plain, np.where(np.arange(6) == axis, commands, 0.0))
    assert np.abs(without - moved[0]).max() > 1e-6


def test_lag_as_slow_as_the_current_loop_is_no_special_case() -> None:
    commands, T = torques(200, seed=33), 1 / (2 * np.pi * 200.0)
    equal = angles(plant(one("drive_lag", T), f_current=200.0), commands)
    nearly = angles(plant(one("drive_lag", T * (1 + 1e-9)), f_current=200.0), commands)
    # the delay differs by 8e-13 s at 1 rad/s
    assert_close(equal, nearly, atol=1e-11, what="theta")


def test_delay_of_whole_ticks_is_a_late_command() -> None:
    commands, mask = torques(300, seed=34), np.arange(6) == axis_of("time_delay") - 1
    commands = np.where(mask, commands, 0.0)
    subject = angles(plant(one("time_delay", 3 * BASE)), commands)
    late = angles(plant(np.zeros(real().n_gains), command_delay=3), commands)
    assert_close(subject, late, atol=1e-14, what="theta")


def test_delay_between_ticks_is_interpolated() -> None:
    """2.4 ticks are a whole number of substeps when there are five of them."""
    commands = torques(300, seed=35)
    coarse = angles(plant(one("time_delay", 2.4 * BASE)), commands)
    fine = angles(plant(one("time_delay", 2.4 * BASE), substeps=5), commands)
    nearest = angles(plant(one("time_delay", 2.0 * BASE), substeps=5), commands)
    error, step = np.abs(coarse - fine).max(), np.abs(nearest - fine).max()
    assert error < 0.02 * step
    assert step > 1e-6


@pytest.mark.parametrize("id", ["drive_gain", "torque_saturation", "drive_lag", "time_delay"])
def test_drive_reports_what_the_joint_does_not_get(id: str) -> None:
    commands = torques(60, seed=36)
    nominal, subject = plant(np.zeros(real().n_gains)), plant(only(real(), id))
    for tau in commands:
        expected, actual = nominal.tick(tau=tau), subject.tick(tau=tau)
        assert np.array_equal(actual["tau_meas"], expected["tau_meas"])
    assert np.abs(subject.y["theta"] - nominal.y["theta"]).max() > 1e-8


def test_eccentric_encoder_misreads_the_angle_alone() -> None:
    commands, gains = torques(200, seed=37), only(real(), "encoder_eccentricity")
    nominal, subject = plant(np.zeros(real().n_gains)), plant(gains)
    e_c, e_s = gains[gains != 0]
    axis = axis_of("encoder_eccentricity") - 1
    for tau in commands:
        theta, read = nominal.tick(tau=tau)["theta"], subject.tick(tau=tau)["theta"]
        error = np.zeros(6)
        error[axis] = e_c * (np.cos(theta[axis]) - 1) + e_s * np.sin(theta[axis])
        assert_close(read, theta + error, atol=1e-15, what="theta")
    assert np.abs(error).max() > 1e-6
    assert np.array_equal(subject.y["x_E"], nominal.y["x_E"])


@pytest.mark.parametrize(("id", "value"), [("drive_lag", -1e-4), ("time_delay", 2.0)])
def test_plant_refuses_lags_that_cannot_be(id: str, value: float) -> None:
    with pytest.raises(StartError, match=rf"^effect: axis {axis_of(id)} has a lag of"):
        plant(one(id, value))


def along(ticks: int) -> list[Instant]:
    """A motion of the kinematics at the feedforward's sample time."""
    block, outputs = load("kinematics"), []
    block.start()
    w, phase = 9.0, np.arange(6)
    for k in range(ticks):
        t = TS * k
        theta = 0.1 * np.sin(w * t + phase) - 0.1 * np.sin(phase)
        thetad, thetadd = (0.1 * w * np.cos(w * t + phase), -0.1 * w**2 * np.sin(w * t + phase))
        y = block.tick(theta=theta, thetad=thetad, thetadd=thetadd)
        outputs.append(Instant(y["x"], y["xd"], y["xdd"], y["z"]))
    return outputs

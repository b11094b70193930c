"""P: how it integrates: equal to its twin, convergence, payloads, turns, strong damping."""

from __future__ import annotations

import numpy as np
import pytest

from flexhex.fmus.common.model.rest import holding_torque
from tests.blocks.loaded import Array, load, machine
from tests.blocks.plant_twin import EXACT, TS, RungeKutta, Twin, motion, started, torques
from tests.compare import assert_close


@pytest.mark.parametrize(
    ("substeps", "f_current"), [(1, 1e3), (2, 1e3), (3, 1e3), (1, 1.0), (1, 3e3), (1, 1e4)]
)
def test_plant_equals_its_twin(substeps: int, f_current: float) -> None:
    """A payload that comes and goes, a torque beyond the limit now and then."""
    block = started(substeps=substeps, f_current=f_current, tau_max=4.0, **EXACT)
    twin = Twin(block, substeps)
    for k, tau in enumerate(1.4 * torques(200, seed=substeps)):
        payload = 0.8 if 60 <= k < 140 else 0.0
        y = block.tick(tau=tau, payload=payload)
        twin.tick(tau, payload)
        # rounding of 300 operations a step, carried on: far below the encoder's 1e-8 rad
        assert_close(y["theta"], twin.y[:6], atol=1e-14, what=f"theta, tick {k}")
        assert_close(y["tau_meas"], twin.tau, atol=1e-13, what=f"tau_meas, tick {k}")
        assert_close(motion(block)[1], twin.y[6:12], atol=1e-12, what=f"thetad, tick {k}")
    x = np.concatenate([twin.y[:6], twin.y[12:43]])
    assert_close(y["x_E"], x[30:33], atol=1e-14, what="x_E")


def replay(substeps: int, commands: Array) -> Array:
    block = started(substeps=substeps, **EXACT)
    return np.array([block.tick(tau=tau)["theta"] for tau in commands])


def test_plant_substeps_converge_below_the_encoder_step() -> None:
    """Against 16 substeps over 0.2 s open loop: one is off by 1e-9 rad, two by a fifteenth.

    The first substeps, by Runge-Kutta, leave most of it: order four.
    """
    commands = torques(800, seed=6)
    fine = replay(16, commands)
    assert np.abs(fine).max() > 0.1
    error = {n: float(np.abs(replay(n, commands) - fine).max()) for n in (1, 2)}
    assert error[1] < 0.2 * machine().encoder.step
    assert 12 < error[1] / error[2] < 20, "order four"


@pytest.mark.parametrize("load_kg", [0.8, 2e-3])
def test_plant_follows_the_equations(load_kg: float) -> None:
    """Against four Runge-Kutta steps a tick, while a payload comes and goes."""
    block, exact = started(**EXACT), RungeKutta(load("plant"), 4)
    for k, tau in enumerate(torques(240, seed=14)):
        payload = load_kg if 80 <= k < 160 else 0.0
        theta = block.tick(tau=tau, payload=payload)["theta"]
        exact.tick(tau, payload)
        assert_close(theta, exact.y[:6], atol=5e-10, what=f"theta, tick {k}")
    assert np.abs(theta).max() > 0.01


def paths(commands: Array, **actuators: float) -> tuple[Array, Array]:
    """theta (ticks, 6) with one substep and with 16; actuators: what every actuator has."""
    listed, names = [], {"d": 2, "c": 3}
    for substeps in (1, 16):
        p = load("plant").p["actuator"]
        for name, value in actuators.items():
            p[names[name] :: 22] = value
        block, theta = started(substeps=substeps, actuator=p, **EXACT), []
        for tau in commands:
            y = block.tick(tau=tau)
            assert y["fault"] == 0.0
            theta.append(y["theta"])
        listed.append(np.array(theta))
    return listed[0], listed[1]


def test_plant_turns_with_its_hysteresis() -> None:
    """Ten times the hysteresis, and every joint turns thrice: 6e-10 rad in 0.2 s. With z of a
    joint that does not turn within a substep it is 3e-7 rad."""
    t, offset = TS * np.arange(800)[:, None], np.array(holding_torque(machine()))
    theta, fine = paths(offset + 2.0 * np.cos(2 * np.pi * (9 + np.arange(6)) * t), c=0.8)
    turns = np.sum(np.diff(np.sign(np.diff(fine, axis=0)), axis=0) != 0, axis=0)
    assert turns.min() >= 3
    assert np.abs(theta - fine).max() < 0.1 * machine().encoder.step


def test_plant_follows_what_is_too_fast_for_its_past() -> None:
    """Motors damped 5000 times as much: extrapolation alone would be unstable."""
    theta, fine = paths(torques(400, seed=6), d=60.0)
    assert np.ptp(fine) > 1e-3
    assert np.abs(theta - fine).max() < 2 * machine().encoder.step

"""P: energy, stops, quanta, delays, payload."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexhex.fmus.common.errors import StartValueError
from flexhex.fmus.plant.interface import interface
from tests.blocks.loaded import Array, StartError, load, machine
from tests.blocks.plant_twin import EXACT, HOLD, TS, motion, started, torques
from tests.compare import assert_close
from tests.oracles import geometry, lagrange
from tests.oracles.machine import read_machine


def without_actuators() -> Array:
    """No friction, cogging, offset, spring: the mechanism alone."""
    return np.zeros(132)


def test_no_body_has_a_negative_mass_moment_or_stiffness() -> None:
    """What else stands in the array, first moments and products of inertia, may be negative."""
    (mechanism,) = (v for v in interface(machine()).variables if v.name == "mechanism")
    signed = [n for n, low in zip(mechanism.elements, mechanism.lows, strict=True) if low < 0]
    assert {name.rpartition(".")[2] for name in signed} == {
        "mc_x", "mc_y", "mc_z", "J_xy", "J_xz", "J_yz"
    }  # fmt: skip
    wrong = [-1.0, *mechanism.starts[1:]]
    with pytest.raises(StartValueError, match=r"upper\[1\].J starts at -1 kg m2, allowed 0 to 100"):
        replace(mechanism, start=wrong)


def test_plant_keeps_its_loops_closed() -> None:
    block = started(**EXACT)
    for tau in torques(2000, seed=4):
        block.tick(tau=tau)
    theta, _, d = motion(block)
    D = geometry.constraints(read_machine(), np.concatenate([theta, d]))
    assert np.abs(theta).max() > 0.02
    # without the correction it would be 1e-14, and growing
    assert np.linalg.norm(D) < 2e-15


def test_plant_conserves_energy() -> None:
    """Undamped under constant torque, with a payload, for 0.45 s; the energy is the oracle's.

    Up to 0.6 J of motion; what is lost is the rounding of 10 J of height, 5e-15 J.
    """
    payload, subject = 0.5, read_machine().with_payload(0.5)
    gravity = lagrange.gravity_torque(subject, np.zeros(6))
    push = gravity + np.array([0.3, -0.2, 0.25, 0.1, -0.3, 0.2])
    # the current loop settles within the first tick, and does no harm before
    block = started(actuator=without_actuators(), f_current=1e5, **EXACT)
    block.tick(tau=push, payload=payload)

    def energy() -> tuple[float, float]:
        theta, thetad, d = motion(block)
        x = np.concatenate([theta, d])
        xd = geometry.dependent_rates(subject, x) @ thetad
        T = float(lagrange.kinetic_energy(subject, x, xd))
        V = lagrange.gravity_energy(subject, x) + lagrange.elastic_energy(subject, x)
        return T, T + float(V) - float(push @ theta)

    start, kinetic = energy()[1], []
    for k in range(1800):
        y = block.tick()
        if k % 200 == 199:
            T, total = energy()
            kinetic.append(T)
            assert_close(total, start, atol=1e-13, what=f"energy, tick {k}")
    assert y["end_stop"] == 0.0
    assert max(kinetic) > 0.5


def test_plant_stops_at_the_end_and_leaves_it_again() -> None:
    block = started(stroke=0.1)
    ticks_at_stop = 0
    for _ in range(2000):
        y = block.tick(tau=2 * HOLD)
        assert np.abs(y["theta"]).max() <= 0.1 + machine().encoder.step
        assert y["fault"] == 2.0 * y["end_stop"]
        ticks_at_stop += int(y["end_stop"])
    assert ticks_at_stop > 1000
    assert np.abs(y["theta"]).max() > 0.09
    for _ in range(400):
        y = block.tick(tau=np.zeros(6))
    assert (y["end_stop"], y["fault"]) == (0.0, 0.0)
    assert np.abs(y["theta"]).max() < 0.09


def test_plant_tells_divergence_from_an_end_stop() -> None:
    """Steps too long for the equations: Dahl's with a width of 1e-9 rad (the stages of the first
    steps then leave its range), or motors damped 1e5 times as much as inertia follows."""
    narrow = machine().actuator.model_copy(update={"sigma": 1e-9})
    sharp = load("plant", machine().model_copy(update={"actuator": narrow}))
    sharp.start()
    damped = np.zeros(132)
    damped[2::22] = 100.0
    light = started(actuator=damped, mechanism=1e-6 * load("plant").p["mechanism"])
    for block in (sharp, light):
        faults = set()
        for tau in torques(50, seed=2):
            y = block.tick(tau=tau)
            faults.add(y["fault"])
            assert y["end_stop"] == 0.0
            assert np.isfinite(y.values).all()
        assert 3.0 in faults


def test_step_too_fine_for_a_double_is_none() -> None:
    """Angles divided by it are infinite; `make fuzz` found it."""
    finest, without = (started(theta_step=h, tau_step=h) for h in (5e-324, 0.0))
    for tau in torques(20, seed=5):
        y, z = finest.tick(tau=tau), without.tick(tau=tau)
        assert y.values.tobytes() == z.values.tobytes()


def test_plant_quantises_like_its_sensors_and_drives() -> None:
    coarse, fine = started(theta_step=1e-4, tau_step=0.0), started(theta_step=0.0, tau_step=0.0)
    for tau in torques(300, seed=8):
        theta, exact = coarse.tick(tau=tau)["theta"], fine.tick(tau=tau)["theta"]
        counts = theta / 1e-4
        assert_close(counts, np.round(counts), atol=1e-9, what="counts")
        assert np.abs(theta - exact).max() <= 0.5e-4 + 1e-12
    stepped = started(tau_step=0.01)
    for tau in torques(300, seed=8):
        tau_meas = stepped.tick(tau=tau)["tau_meas"]
        assert_close(tau_meas, 0.01 * np.round(tau_meas / 0.01), atol=1e-12, what="tau_meas")


def test_plant_quantises_the_command_too() -> None:
    """A command within half a current step of a multiple acts like that multiple."""
    rough, plain = started(tau_step=0.5), started(tau_step=0.5)
    for tau in np.round(torques(100, seed=9) / 0.5) * 0.5:
        assert np.array_equal(rough.tick(tau=tau + 0.2)["theta"], plain.tick(tau=tau)["theta"])


@pytest.mark.parametrize(("command", "measurement"), [(3, 0), (0, 5), (2, 40), (40, 1)])
def test_plant_delays_are_whole_ticks(command: int, measurement: int) -> None:
    """An extra delay shifts the record and changes nothing else (before it, no torque)."""
    commands = torques(200, seed=10)
    rest = np.zeros((command, 6))
    plain = started(**EXACT)
    delayed = started(command_delay=command, measurement_delay=measurement, **EXACT)
    now, late = [plain.y.values.copy()], [delayed.y.values.copy()]
    for tau in np.concatenate([rest, commands]):
        now.append(plain.tick(tau=tau).values.copy())
    for tau in commands:
        late.append(delayed.tick(tau=tau).values.copy())
    measured = slice(0, 12)
    for k in range(measurement, len(late)):
        assert np.array_equal(late[k][measured], now[k - measurement][measured]), f"tick {k}"
    # the pose is not measured: it is shown as it is
    assert np.array_equal(late[-1][12:18], now[len(late) - 1][12:18])


def test_plant_current_loop_is_first_order() -> None:
    f = 800.0
    block, command = started(f_current=f, **EXACT), np.array([1.0, -1.0, 2.0, 0.5, -0.5, 3.0])
    for k in range(1, 20):
        tau = block.tick(tau=command)["tau_meas"]
        expected = command * (1 - np.exp(-2 * np.pi * f * k * TS))
        assert_close(tau, expected, atol=1e-14, what=f"tau_meas, tick {k}")


def test_plant_limits_the_torque() -> None:
    block = started(tau_max=1.5, f_current=1e5, **EXACT)
    y = block.tick(tau=np.array([9.0, -9.0, 1.5, 1.0, 0.0, -1.6]))
    assert_close(y["tau_meas"], [1.5, -1.5, 1.5, 1.0, 0.0, -1.5], atol=1e-12, what="tau_meas")


def test_plant_carries_its_payload() -> None:
    """What accelerates the loaded machine from rest is the weight that the oracle gives it."""
    subject, payload = read_machine(), 1.3
    loaded = subject.with_payload(payload)
    extra = lagrange.gravity_torque(loaded, np.zeros(6))
    # held exactly, it stays; without the payload's share it sinks
    for torque, moves in ((extra, False), (lagrange.gravity_torque(subject, np.zeros(6)), True)):
        block = started(actuator=without_actuators(), f_current=1e5, **EXACT)
        for _ in range(200):
            y = block.tick(tau=torque, payload=payload)
        sunk = 0.3 - y["x_E"][2]
        assert sunk > 1e-3 if moves else abs(sunk) < 1e-6


def test_plant_starts_at_rest_at_neutral() -> None:
    y = load("plant").start()
    assert not y["theta"].any()
    assert not y["tau_meas"].any()
    assert_close(y["x_E"], read_machine().x_E0, atol=1e-15, what="x_E")


@pytest.mark.parametrize("name", ["substeps", "command_delay", "measurement_delay"])
def test_plant_refuses_what_is_not_whole(name: str) -> None:
    with pytest.raises(StartError, match=rf"^{name} = 2.5, must be a whole number$"):
        started(**{name: 2.5})


def test_plant_state_is_all_there_is() -> None:
    """Also in the first ticks, while the past is gathered, and with a new payload."""
    block, commands = started(command_delay=4, measurement_delay=7), torques(60, seed=12)
    for ticks in (0, 2, 5, 60):
        block.start()
        for tau in commands[:ticks]:
            block.tick(tau=tau, payload=0.3)
        kept = block.state.copy()
        first = [block.tick(tau=tau, payload=0.1).values.copy() for tau in commands]
        block.state[:] = kept
        again = [block.tick(tau=tau, payload=0.1).values.copy() for tau in commands]
        assert np.array_equal(first, again)

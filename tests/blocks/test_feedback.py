"""C: equal to its twin, bumpless, within its limits, r and theta of one instant."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.blocks.feedback_design import TS, gains
from tests.blocks.feedback_twin import Twin
from tests.blocks.loaded import Array, Loaded, StartError, load, machine
from tests.compare import assert_close

NAMES = ("tau", "tau_fb", "e")
PLAIN = {"tau_step": 0.0, "reference_delay": 0.0}
"""Without current steps and delay."""


def started(**parameters: Any) -> Loaded:
    block = load("feedback")
    block.start(**parameters)
    return block


def twin_of(block: Loaded) -> Twin:
    p = block.p
    same = {name: p[name] for name in ("Ts", "t_i", "t_d", "t_f", "tau_max", "tau_step", "ff_gain")}
    return Twin(kp=p["kp"][0], delay=p["reference_delay"], e_max=p["e_max"], **same)


def wandering(ticks: int, seed: int, error: float) -> tuple[Array, Array, Array]:
    """r, theta [rad], tau_ff [N m] (ticks, 6): angles that come apart by up to `error`."""
    rng, t = np.random.default_rng(seed), TS * np.arange(ticks)[:, None]

    def wave(size: float) -> Array:
        f, phase = rng.uniform(1, 20, 6), rng.uniform(0, 6, 6)
        return np.asarray(size * np.sin(2 * np.pi * f * t + phase))

    r = wave(0.2)
    return r, r + wave(error) + rng.normal(0, 1e-6, r.shape), wave(4.0)


@pytest.mark.sample(6)
@pytest.mark.parametrize("delay", [0.0, 0.4, 1.0, 1.5, 6.64, 63.7, 64.0])
@pytest.mark.parametrize("ff_gain", [0.0, 0.5, 1.0])
def test_feedback_equals_its_twin(delay: float, ff_gain: float) -> None:
    """Through saturation and following errors; these two must come about, or nothing is shown."""
    block = started(reference_delay=delay, ff_gain=ff_gain, tau_max=20.0)
    twin, faults = twin_of(block), set()
    motion = wandering(1500, seed=round(10 * delay), error=0.17)
    for k, (r, theta, tau_ff) in enumerate(zip(*motion, strict=True)):
        expected = twin.tick(r, theta, tau_ff)
        y = block.tick(r=r, theta=theta, tau_ff=tau_ff)
        # e: rounding of interpolated 0.2 rad; torque: that times the derivative's 870 N m/rad
        for name, atol in zip(NAMES, (2e-12, 2e-12, 4e-16), strict=True):
            assert_close(y[name], expected[name], atol=atol, what=f"{name}, tick {k}")
        assert y["fault"] == expected["fault"]
        faults.add(y["fault"])
    assert {0.0, 2.0} <= faults
    assert delay < 6 or 3.0 in faults


def test_feedback_takes_another_gain_for_each_joint() -> None:
    kp = np.array([10.0, 20.0, 0.0, 40.0, 50.0, 60.0])
    block = started(kp=kp, **PLAIN)
    block.tick()
    tau = block.tick(theta=np.full(6, -1e-3))["tau_fb"]
    assert tau[0] > 0
    assert_close(tau, tau[0] * kp / kp[0], rtol=1e-15)


def test_feedback_state_is_all_there_is() -> None:
    block = started(tau_max=20.0)
    r, theta, tau_ff = wandering(200, seed=2, error=0.1)
    for k in range(100):
        block.tick(r=r[k], theta=theta[k], tau_ff=tau_ff[k])
    kept = block.state.copy()

    def rest() -> list[Array]:
        ticks = range(100, 200)
        return [block.tick(r=r[k], theta=theta[k], tau_ff=tau_ff[k]).values.copy() for k in ticks]

    first = rest()
    block.state[:] = kept
    assert np.array_equal(first, rest())


def test_feedback_starts_without_a_bump() -> None:
    r, theta = np.linspace(-0.3, 0.3, 6), np.linspace(-0.2, 0.35, 6)
    block = started(tau_step=0.0)
    y = block.tick(r=r, theta=theta)
    assert_close(y["tau_fb"], np.zeros(6), atol=1e-14, what="first torque")
    assert_close(y["e"], r - theta, atol=2e-16, what="first error")
    y = block.tick()
    growth = gains().kp / gains().t_i * TS * (r - theta)
    assert_close(y["tau_fb"], growth, atol=1e-13, what="second torque")


def test_feedback_passes_the_feedforward_from_the_first_tick() -> None:
    tau_ff = np.linspace(-3, 3, 6)
    for ff_gain in (0.0, 1.0):
        y = started(ff_gain=ff_gain, **PLAIN).tick(tau_ff=tau_ff)
        assert np.array_equal(y["tau"], ff_gain * tau_ff)
        assert not y["tau_fb"].any()


@settings(max_examples=30, deadline=None)
@given(delay=st.floats(0, 64), shape=st.lists(st.floats(-1, 1), min_size=4, max_size=4))
def test_feedback_delay_keeps_cubics(delay: float, shape: list[float]) -> None:
    block = started(reference_delay=delay)
    polynomial = np.polynomial.Polynomial(0.1 * np.array(shape), domain=[0, 80])
    for k in range(81):
        e = block.tick(r=np.full(6, polynomial(k)))["e"]
    assert_close(e, np.full(6, polynomial(80 - delay)), atol=2e-15, what="delayed r")


def test_feedback_whole_delays_are_exact() -> None:
    rng = np.random.default_rng(4)
    r = rng.uniform(-0.5, 0.5, (200, 6))
    for delay in (0, 1, 2, 6, 63, 64):
        block = started(reference_delay=delay)
        for k in range(200):
            e = block.tick(r=r[k])["e"]
            assert np.array_equal(e, r[max(k - delay, 0)]), f"delay {delay}, tick {k}"


def test_feedback_delay_is_good_for_fast_references() -> None:
    """sin at 5 Hz, 0.19 rad, 6.64 steps: the cubic's error is some (omega Ts)^4 / 40."""
    block, w = started(reference_delay=6.64), 2 * np.pi * 5
    for k in range(400):
        e = block.tick(r=np.full(6, 0.19 * np.sin(w * TS * k)))["e"]
        if k > 10:
            assert abs(e[0] - 0.19 * np.sin(w * TS * (k - 6.64))) < 0.19 * (w * TS) ** 4 / 40


def test_feedback_gives_whole_current_steps_without_losing_torque() -> None:
    step = machine().drive.K_t * machine().drive.I_step
    tau_ff = np.array([0.4, -0.37, 0.1234, 1.2, 0.0, 5.01]) * step
    block, total = started(reference_delay=0.0), np.zeros(6)
    for k in range(1, 1001):
        tau = block.tick(tau_ff=tau_ff)["tau"]
        assert_close(tau / step, np.round(tau / step), atol=1e-12, what="steps")
        total += tau
        # what is owed never exceeds half a step, however long
        assert np.abs(total - k * tau_ff).max() < 0.501 * step
    assert np.abs(total).max() > 100 * step


def test_feedback_stays_within_a_limit_that_is_no_whole_number_of_steps() -> None:
    block = started(tau_max=1.0, tau_step=0.3, reference_delay=0.0)
    for _ in range(50):
        tau = block.tick(tau_ff=np.array([5.0, -5.0, 0.99, -0.99, 1.0, 0.95]))["tau"]
        assert np.abs(tau).max() <= 1.0
    assert tau[0] > 0.85
    assert tau[1] < -0.85


def test_feedback_keeps_what_it_owes_at_a_limit_of_broken_steps() -> None:
    """tau_max = 1.0 in steps of 0.3: what is wanted near the largest whole step, 0.9, is given
    on average. A command clipped to 1.0 after rounding up to 1.2 would lose 0.2 each time."""
    block, wanted = started(tau_max=1.0, tau_step=0.3, reference_delay=0.0), np.zeros(6)
    total, low = np.zeros(6), np.array([0.88, -0.88, 0.8, -0.8, 0.1, 0.0])
    for k in range(400):
        # every other tick far beyond the limit: nothing of that may be owed afterwards
        wanted = np.where(k % 2, 5 * np.sign(low), low)
        tau = block.tick(tau_ff=wanted)["tau"]
        assert_close(tau / 0.3, np.round(tau / 0.3), atol=1e-12, what="whole steps")
        assert np.abs(tau).max() <= 1.0
        total += tau - np.clip(wanted, -0.9, 0.9)
        assert np.abs(total).max() < 0.5 * 0.3 + 1e-9
    # back at zero, no more than half a step is made good
    after = sum(block.tick(tau_ff=np.zeros(6))["tau"] for _ in range(10))
    assert np.abs(np.asarray(after)).max() <= 0.3


def test_feedback_takes_a_current_step_too_fine_for_a_double_for_none() -> None:
    """The limit counted in such steps is infinite; every torque came out as the limit."""
    finest, without = (started(tau_step=h, reference_delay=0.0) for h in (5e-324, 0.0))
    for r in (0.0, 1e-3, -2e-3):
        y, z = finest.tick(r=np.full(6, r)), without.tick(r=np.full(6, r))
        assert y.values.tobytes() == z.values.tobytes()


def test_feedback_refuses_a_current_step_beyond_the_limit() -> None:
    with pytest.raises(StartError, match=r"^tau_step = 0.3 N m, more than tau_max = 0.2 N m$"):
        started(tau_max=0.2, tau_step=0.3)


def test_feedback_faults_come_and_go() -> None:
    block = started(**PLAIN)
    assert block.tick()["fault"] == 0.0
    assert block.tick(tau_ff=[0, 0, 0, 0, 0, 27.1])["fault"] == 2.0
    far = np.array([0, 0, 0.21, 0, 0, 0])
    assert block.tick(tau_ff=0.0, theta=far)["fault"] == 3.0
    # the derivative has to forget the jump: 0.1 s are 18 of its lags
    for _ in range(400):
        y = block.tick(theta=np.zeros(6))
    assert y["fault"] == 0.0

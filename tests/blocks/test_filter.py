"""W: equal to its twin, of one instant, without transient, drift or bias of the basis."""

from __future__ import annotations

import numpy as np
import pytest

from tests.blocks.filter_twin import Array, Twin
from tests.blocks.loaded import Loaded, StartError, load, machine
from tests.compare import assert_close

TS = 0.0005
DELAY = 51.5
OUTPUTS = ("theta_f", "theta_fd", "theta_fdd", "tau_f", "chi_f")


def swings(ticks: int, seed: int) -> tuple[Array, Array]:
    """Angles that turn back and forth within the stroke, torques with noise (ticks, 6)."""
    rng = np.random.default_rng(seed)
    t = TS * np.arange(ticks)[:, None]
    theta = 0.25 * np.sin(2 * np.pi * rng.uniform(0.3, 2.0, 6) * t + rng.uniform(0, 6, 6))
    theta += rng.normal(0, 1e-6, theta.shape)
    return theta, 5 * np.cos(3 * t + rng.uniform(0, 6, 6)) + rng.normal(0, 0.01, theta.shape)


def run(block: Loaded, theta: Array, tau: Array) -> dict[str, Array]:
    """Outputs after every tick."""
    rows: dict[str, list[Array]] = {name: [] for name in OUTPUTS}
    for angle, torque in zip(theta, tau, strict=True):
        y = block.tick(theta=angle, tau_meas=torque)
        for name in OUTPUTS:
            rows[name].append(y[name])
    return {name: np.array(values) for name, values in rows.items()}


def started(**parameters: float) -> Loaded:
    block = load("filter")
    block.start(**parameters)
    return block


@pytest.mark.parametrize("basis", [0, 1])
@pytest.mark.parametrize("alignment", [0, 1, 5, 20])
def test_filter_equals_its_twin(basis: int, alignment: int) -> None:
    theta, tau = swings(600, seed=alignment)
    a = machine().actuator
    twin = Twin(TS, a.sigma, a.omega_cog, alignment=alignment, raw_basis=bool(basis))
    expected = twin.run(theta, tau)
    actual = run(started(alignment=alignment, basis=basis), theta, tau)
    # rounding: 1e-16 of the angle, divided by Ts and Ts^2; 324 rad of phase at the 9th harmonic
    atol = {"theta_f": 1e-15, "theta_fd": 1e-12, "theta_fdd": 1e-8, "tau_f": 1e-13, "chi_f": 1e-12}
    for name in OUTPUTS:
        assert_close(actual[name], expected[name], atol=atol[name], what=name)


def test_filter_starts_without_transient() -> None:
    theta, tau = np.linspace(-0.3, 0.3, 6), np.linspace(2, -3, 6)
    y = run(started(), np.tile(theta, (300, 1)), np.tile(tau, (300, 1)))
    for row in (0, 1, 150, 299):
        assert_close(y["theta_f"][row], theta, atol=2e-16, what="theta_f")
        assert_close(y["tau_f"][row], tau, atol=2e-15, what="tau_f")
    assert not y["theta_fd"].any()
    assert not y["theta_fdd"].any()


def test_filter_brings_polynomials_to_one_instant() -> None:
    # a symmetric window keeps a straight line and shifts a parabola by a constant
    t = TS * np.arange(400)
    theta = np.tile((0.1 + 0.7 * t - 0.9 * t**2)[:, None], 6)
    y = run(started(alignment=3), theta, np.tile((2 - 5 * t)[:, None], 6))
    at = t[-1] - DELAY * TS
    assert_close(y["theta_fd"][-1], np.full(6, 0.7 - 1.8 * at), atol=1e-11, what="theta_fd")
    assert_close(y["theta_fdd"][-1], np.full(6, -1.8), atol=1e-8, what="theta_fdd")
    assert_close(y["tau_f"][-1], np.full(6, 2 - 5 * (at - 3 * TS)), atol=1e-13, what="tau_f")


@pytest.mark.parametrize("alignment", [0, 1, 4])
def test_filter_delays_the_basis_like_the_torque(alignment: int) -> None:
    # at constant speed the window changes amplitudes of cos, sin, never their phase
    speed, ticks = 0.4, 400
    theta = np.tile((speed * TS * (np.arange(ticks) - ticks / 2))[:, None], 6)
    y = run(started(alignment=alignment), theta, np.zeros((ticks, 6)))
    angle = theta[-1, 0] - speed * TS * (DELAY + alignment)
    for n in range(1, 10):
        cos_n, sin_n = y["chi_f"][-1][2 * n - 1 : 2 * n + 1]
        phase = 36.0 * n * angle
        off = np.arctan2(sin_n, cos_n) - phase
        assert abs((off + np.pi) % (2 * np.pi) - np.pi) < 1e-10


def cogging_bias(basis: int) -> float:
    """Largest error of the ninth harmonic's torque as (26) sees it, relative to the filtered."""
    ticks, n = 1200, 9
    t = TS * np.arange(ticks)
    theta = np.tile((0.1 * np.sin(2 * np.pi * t))[:, None], 6)
    tau = np.cos(36.0 * n * theta)
    y = run(started(alignment=1, basis=basis), theta, tau)
    column = y["chi_f"][:, 2 * n - 1 :: 19]
    settled = slice(200, None)
    return float(np.abs(column - y["tau_f"])[settled].max() / np.abs(y["tau_f"][settled]).max())


def test_filter_of_the_raw_basis_is_the_filtered_torque() -> None:
    assert cogging_bias(basis=1) < 1e-13


def test_filter_of_the_filtered_angle_is_biased_as_the_design_says() -> None:
    # the switch to the paper's form: there the bias is real, docs/decisions/0003-one-instant.md
    assert cogging_bias(basis=0) > 0.25


def test_filter_forgets_what_left_the_window() -> None:
    # a recursive sum would keep rounding errors of the past; 0.3 rad after 3000 ticks of noise
    theta, tau = swings(3000, seed=1)
    rest = np.full((130, 6), 0.3)
    late, fresh = started(), started()
    run(late, theta, 1e3 * tau)
    after, alone = run(late, rest, rest), run(fresh, rest, rest)
    for name in ("theta_f", "theta_fd", "theta_fdd", "tau_f"):
        assert np.array_equal(after[name][-1], alone[name][-1]), name


def test_filter_state_is_all_there_is() -> None:
    theta, tau = swings(300, seed=2)
    block = started()
    run(block, theta, tau)
    kept = block.state.copy()
    first = run(block, theta, tau)
    block.state[:] = kept
    again = run(block, theta, tau)
    for name in OUTPUTS:
        assert np.array_equal(first[name], again[name]), name


def test_filter_first_outputs_are_those_of_rest() -> None:
    y = load("filter").start()
    assert not y["theta_f"].any()
    assert y["chi_f"].tolist() == 6 * [0.0, *9 * (1.0, 0.0)]


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("alignment", 1.5, "alignment = 1.5, must be a whole number"),
        ("basis", 0.5, "basis = 0.5, must be 0 or 1"),
    ],
)
def test_filter_refuses_what_is_not_whole(name: str, value: float, message: str) -> None:
    with pytest.raises(StartError) as error:
        load("filter").start(**{name: value})
    assert str(error.value) == message


def state_at_rest(noise: float, play: float) -> float:
    """z of joint 1 after a move of 0.1 rad and five seconds of standing still."""
    t = TS * np.arange(12000)
    clean = np.tile(0.1 * np.minimum(t, 1.0)[:, None], 6)
    theta = clean + noise * np.random.default_rng(8).standard_normal(clean.shape)
    y = run(started(play=play), theta, np.zeros_like(theta))
    return float(y["chi_f"][-1, 0])


def test_play_keeps_a_dahl_state_that_noise_would_wear_off() -> None:
    sure = state_at_rest(0.0, 0.0)
    # 0.1 rad are seven widths
    assert sure == pytest.approx(1.0, abs=2e-3)
    assert state_at_rest(2e-6, 0.0) < 0.5
    # the gap, 16 urad, is a thousandth of the width
    assert state_at_rest(2e-6, 8e-6) == pytest.approx(sure, abs=2e-3)


def test_play_follows_behind_its_gap_exactly() -> None:
    theta = np.tile(np.array([0.0, 0.05, 0.0495, 0.03])[:, None], 6)
    followed = np.array([0.0, 0.049, 0.049, 0.031])
    block = started(play=1e-3)
    twin = started()
    for angle, behind in zip(theta, np.tile(followed[:, None], 6), strict=True):
        y, wanted = (
            r.tick(theta=a, tau_meas=np.zeros(6)) for r, a in ((block, angle), (twin, behind))
        )
    # what is in the ring: the sum over the window is the same, rounding apart
    assert_close(y["chi_f"][::19], wanted["chi_f"][::19], atol=1e-14, what="z")

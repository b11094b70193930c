"""Forward dynamics from torques at chosen states, beside SciPy and textbook equations."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from flexhex.diagnosis.basemodels.base import Base, Known
from flexhex.diagnosis.basemodels.bases import base_of
from flexhex.diagnosis.basemodels.columns import ColumnBase
from flexhex.diagnosis.estimation.forward.beside import Friction
from flexhex.diagnosis.estimation.forward.integrate import Windows, invertible, mechanics, simulated
from flexhex.diagnosis.estimation.friction import Form
from flexhex.diagnosis.kinds import ROTARY
from flexhex.diagnosis.logs import Log
from tests.conftest import ROOT
from tests.diagnosis.estimation.forward.pendulum import P, acceleration, drive, integrated

Array = NDArray[np.float64]
EXAMPLE = f"{ROOT / 'flexhex/init/two_links.py'}:TwoLinks"
SECONDS = 0.8
DRY, SHARP, VISCOUS = 1.5, 0.02, 0.2
Q = np.array([[0.3, -0.4], [-0.8, 0.5], [1.0, 1.2]])
V = np.array([[0.5, -1.0], [0.0, 0.0], [-2.0, 1.5]])


@pytest.fixture(scope="module")
def base() -> Base:
    return base_of(EXAMPLE, None, Log.of("run.csv", 0.002, *np.ones((2, 10, 2))))


def parameters(base: Base) -> Array:
    return np.array([P[known.name] for known in base.linear])


def windows(dt: float, far: float = 1e3) -> Windows:
    """Three that begin at other states and times; angles as they are measured do not matter."""
    steps, begin = round(SECONDS / dt), np.array([0.0, 0.3, 1.1])
    middle = begin[:, None] + dt * (np.arange(steps) + 0.5)
    theta = np.repeat(Q[:, None], steps + 1, axis=1)
    return Windows(theta, V, drive(middle), drive(middle), begin, np.full(2, far), dt)


def solved(dt: float, rubs: bool) -> Array:
    def own(rate: float) -> float:
        return DRY * np.tanh(rate / SHARP) + VISCOUS * rate if rubs else 0.0

    at = dt * np.arange(round(SECONDS / dt) + 1)
    starts = zip(Q, V, (0.0, 0.3, 1.1), strict=True)
    return np.stack([integrated(q, v, at, (own, own), start) for q, v, start in starts])


def friction() -> tuple[list[Friction], list[Array]]:
    form = Form("rate", SHARP, "rad/s")
    parts = [Friction(i, DRY, VISCOUS, 0.0, form) for i in range(2)]
    return parts, [np.zeros((3, 1))] * 2


def test_mass_matrix_and_the_rest_are_those_of_the_textbook(base: Base) -> None:
    mass, h = mechanics(base, parameters(base), Q, V)
    tau = np.array([3.0, -1.0])
    for k in range(3):
        known = np.linalg.solve(mass[k], tau - h[k])
        np.testing.assert_allclose(known, acceleration(Q[k], V[k], tau), rtol=1e-10)


@pytest.mark.parametrize("rubs", [False, True])
def test_windows_follow_what_scipy_integrates(rubs: bool, base: Base) -> None:
    parts, states = friction() if rubs else ([], [])
    told = simulated(base, parameters(base), parts, states, windows(2e-3))
    # error of second order in a step of 2 ms; the arm moves by several rad
    assert np.abs(told - solved(2e-3, rubs)).max() < 3e-3
    assert np.ptp(told, axis=1).max() > 1.0


def test_half_a_step_leaves_a_quarter_of_the_error(base: Base) -> None:
    off = [
        np.abs(simulated(base, parameters(base), [], [], windows(dt)) - solved(dt, False)).max()
        for dt in (8e-3, 4e-3)
    ]
    assert 3 < off[0] / off[1] < 5


class One(ColumnBase):
    """J a alone."""

    def __init__(self) -> None:
        super().__init__((ROTARY,), (Known("J", "kg m2", 0.01, 1.0, "J"),), 0.002)

    def columns(self, theta: Array, thetad: Array, thetadd: Array) -> Array:
        """(samples, 1, 1)."""
        return thetadd[:, :, None]


def pushed(part: Friction, tau: Array, v: float, state: float = 0.0) -> Array:
    """Angles (steps + 1,) of an inertia of 0.01 kg m2."""
    theta = np.zeros((1, len(tau) + 1, 1))
    torque, far = tau[None, :, None], np.full(1, 1e3)
    window = Windows(theta, np.array([[v]]), torque, torque, np.zeros(1), far, 2e-3)
    return simulated(One(), np.array([0.01]), [part], [np.array([[state]])], window)[0, :, 0]


@pytest.mark.parametrize("kind", ["rate", "way"])
def test_dry_friction_holds_what_is_less_and_lets_go_of_more(kind: str) -> None:
    """So steep that the step is 20 000 times that at which an explicit one would swing."""
    part = Friction(0, 1.0, 0.0, 0.0, Form(kind, 1e-5, ""))
    still = pushed(part, np.full(500, 0.9), 0.0)
    assert np.abs(still).max() < 5e-4
    gone = pushed(part, np.full(500, 1.1), 0.0)
    # (1.1 - 1) / 0.01 rad/s2 for a second, once it has come off
    assert gone[-1] == pytest.approx(5.0, rel=0.03)
    # a moving one comes to rest after v^2 J / 2 F_c
    assert pushed(part, np.zeros(500), 5.0)[-1] == pytest.approx(0.125, rel=0.01)


def test_presliding_friction_remembers_its_way() -> None:
    """Dahl's state, beside SciPy, from a start at which the friction is half up."""
    way, dry = 0.01, 0.5
    t = 2e-3 * (np.arange(400) + 0.5)
    tau = 0.8 * np.sin(12 * t)

    def slope(t: float, x: Array) -> list[float]:
        return [x[1], (0.8 * np.sin(12 * t) - dry * x[2]) / 0.01, (x[1] - abs(x[1]) * x[2]) / way]

    at = 2e-3 * np.arange(401)
    known = solve_ivp(slope, (0, at[-1]), [0.0, 0.0, 0.5], "LSODA", at, rtol=1e-9, atol=1e-12).y[0]
    told = pushed(Friction(0, dry, 0.0, 0.0, Form("way", way, "rad")), tau, 0.0, 0.5)
    assert np.abs(told - known).max() < 0.01 * np.ptp(known)


def test_friction_that_leads_turns_before_the_rate_does() -> None:
    dry, lead, sharp = 0.5, 0.01, 0.05
    t = 2e-3 * (np.arange(400) + 0.5)
    tau = 0.8 * np.sin(12 * t)

    def slope(t: float, x: Array) -> list[float]:
        low, high = -200.0, 200.0
        for _ in range(60):
            a = (low + high) / 2
            rest = 0.8 * np.sin(12 * t) - dry * np.tanh((x[1] + lead * a) / sharp) - 0.01 * a
            low, high = (a, high) if rest > 0 else (low, a)
        return [x[1], a]

    at = 2e-3 * np.arange(401)
    known = solve_ivp(slope, (0, at[-1]), [0.0, 0.3], "Radau", at, rtol=1e-8, atol=1e-10).y[0]
    told = pushed(Friction(0, dry, 0.0, 0.0, Form("rate", sharp, "rad/s", lead)), tau, 0.3)
    assert np.abs(told - known).max() < 0.01 * np.ptp(known)


def test_window_that_diverges_ends_and_others_go_on(base: Base) -> None:
    free = simulated(base, parameters(base), [], [], windows(2e-3))
    limited = simulated(base, parameters(base), [], [], windows(2e-3, far=0.4))
    gone = np.isnan(limited).any(axis=2)
    assert gone.any()
    for k in range(3):
        first = int(np.argmax(gone[k])) if gone[k].any() else gone.shape[1]
        assert gone[k, first:].all(), "nothing after the first"
        np.testing.assert_allclose(limited[k, :first], free[k, :first], rtol=1e-12)
        assert np.abs(free[k, :first] - Q[k]).max() <= 0.4


def test_masses_that_have_no_forward_dynamics_are_seen(base: Base) -> None:
    p = parameters(base)
    assert invertible(base, p, Q)
    assert not invertible(base, 0 * p, Q)
    assert not invertible(base, np.where(np.arange(5) == 4, -1.0, 1.0) * p, Q)

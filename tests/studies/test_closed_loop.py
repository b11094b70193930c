"""The closed loop of the generator against its inverse dynamics, and its step control."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from studies.generator import closed_loop
from studies.generator.base import chi
from studies.generator.closed import LISTED, SINGLES, closed_case, simulate_closed
from studies.generator.closed_loop import Loop, integrate, prepare
from studies.generator.draw import INSIDE, assemble, place
from studies.generator.torques import Torque
from tests.compare import assert_close

SHORT = -0.985
"""Length [s] of a run that ends 15 ms after its start, long before its first logged sample."""


def test_forward_dynamics_undo_the_inverse() -> None:
    """Accelerations of three machines side by side, put into the inverse dynamics of each, give
    back the torque they came from: sums of 20 N m, rounding of a 6 x 6 solve."""
    cases = [closed_case(LISTED.index(id), 0.5) for id in ("", "flexible_mode", "uneven_inertia")]
    loop, rng = Loop([prepare(c) for c in cases]), np.random.default_rng(2)
    runs = loop.sigma.size
    q, v = rng.uniform(-0.15, 0.15, (6, runs)), rng.uniform(-1, 1, (6, runs))
    y = loop.start(q, v)
    y[2:] = rng.uniform(-0.01, 0.01, y[2:].shape)
    i, w = rng.uniform(-3, 3, (2, 6, runs))
    a = loop.rates(np.zeros(runs), y, i, w)[1]
    at = 3
    for part, p in zip(loop.part, loop.prepared, strict=True):
        base, (x, xd, xdd) = p.base, (s[:, part] for s in (q, v, a))
        total = base.mechanism.inverse(x, xd, xdd, base.p)
        total = total + chi(p.case.truth.actuator, x, xd, y[2][:, part])
        for s in p.scaled:
            assert isinstance(s.effect, Torque)
            own = y[at : at + s.effect.states, :, part]
            at += s.effect.states
            bare = s.effect.force(np.zeros(x.shape[1]), x, xd, own) + s.effect.inertia(x) * xdd
            total = total + s.gain[:, None] * bare
        assert_close(total, (i - w)[:, part], atol=1e-9)


@pytest.mark.slow
def test_steps_are_short_enough(monkeypatch: pytest.MonkeyPatch) -> None:
    """A hundredth of the tolerance takes more steps and moves the angles by under a hundredth of
    the tracking error (50e-6 rad), though the arm starts at rest, where hysteresis turns."""
    prepared = [prepare(assemble(11, "nothing", (), SHORT, True))]
    coarse, few = integrate(Loop(prepared), SHORT)
    monkeypatch.setattr(closed_loop, "TOLERANCE", closed_loop.TOLERANCE / 100)
    fine, many = integrate(Loop(prepared), SHORT)
    assert many > few
    assert_close(coarse["q"], fine["q"], atol=5e-7)


def test_closed_loop_refuses_what_it_does_not_know() -> None:
    hidden = place(np.random.default_rng(1), "time_delay", 0.01, 1)
    with pytest.raises(ValueError, match="time_delay: not in the closed loop"):
        prepare(assemble(1, "single", (hidden,), 0.2, True))


def test_list_has_twenty_cases_and_only_known_effects() -> None:
    assert len(LISTED) >= 20
    assert set(SINGLES) <= set(INSIDE)
    for number in range(len(LISTED)):
        case = closed_case(number, 0.2)
        assert case.closed
        assert [h.id for h in case.hidden] == [id for id in (LISTED[number],) if id]


def test_cache_gives_the_same_runs_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    case = closed_case(0, -0.99)
    monkeypatch.setattr("studies.generator.closed.WARM", 0.0)  # so that there is something to log
    first = simulate_closed([case], tmp_path)[0]
    assert len(list(tmp_path.iterdir())) == 1
    monkeypatch.setattr("studies.generator.closed.integrate", None)  # may not be called again
    again = simulate_closed([case], tmp_path)[0]
    assert np.array_equal(first.q, again.q)
    assert np.array_equal(first.i, again.i)

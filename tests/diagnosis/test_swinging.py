"""What swings follows accelerations that repeat, from a start that fits what came before."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Motion
from flexhex.diagnosis.hypotheses import swinging
from flexhex.diagnosis.hypotheses.compiled import compiled
from flexhex.diagnosis.hypotheses.swinging import Swung, starts, swung
from flexhex.numeric.prediction import predicted, prediction

Array = NDArray[np.float64]
TS, COUNT, LEAD = 2e-3, 5000, 2000
F, ZETA = 9.0, 0.04


def waves(t: Array) -> Array:
    """Angle [rad] of three waves, the fastest of 6 Hz."""
    each = ((0.7, 0.3, 0.3), (2.3, 1.0, 0.05), (6.0, 2.0, 0.02))
    listed = [size * np.sin(2 * np.pi * f * t + phase) for f, phase, size in each]
    return np.asarray(np.sum(listed, axis=0))


def moved(t: Array, theta: Array, kept: slice) -> Any:
    """A run of these samples of an angle (samples,), with its derivatives."""
    rate = np.gradient(theta, t)
    pace = np.gradient(rate, t)
    columns = {"theta": theta, "thetad": rate, "thetadd": pace}
    motion = Motion(t[kept][0], TS, **{name: v[kept, None] for name, v in columns.items()})
    return SimpleNamespace(run=SimpleNamespace(motion=motion, shift=0.0))


def model_of(monkeypatch: pytest.MonkeyPatch, blocks: list[Any], same: bool = True) -> Any:
    """Of passes that moved alike, or of runs."""
    monkeypatch.setattr(swinging, "alike", lambda a, b: True)
    monkeypatch.setattr(swinging, "rings", lambda blocks: [[0, 1]] if same else [])
    return SimpleNamespace(blocks=blocks, base=SimpleNamespace(n=1, window=0.03))


def test_waves_go_on_and_do_not_grow() -> None:
    t = 0.01 * np.arange(1000)
    values = np.sin(7.0 * t) + 0.3 * np.cos(31.0 * t)
    weights = prediction(values[:800])
    assert predicted(values[:800], weights, 200) == pytest.approx(values[800:], abs=1e-2)
    back = predicted(values[::-1][:800], weights, 200)
    assert back == pytest.approx(values[::-1][800:], abs=1e-2)
    noise = np.random.default_rng(1).standard_normal(300)
    assert np.abs(predicted(noise, prediction(noise), 5000)).max() < 2 * np.abs(noise).max()
    assert not predicted(np.zeros(30), prediction(np.zeros(30)), 10).any()


def test_noise_of_passes_is_no_acceleration(monkeypatch: pytest.MonkeyPatch) -> None:
    t = np.linspace(0.0, TS * COUNT, COUNT, endpoint=False)
    rng, inside = np.random.default_rng(2), slice(2, -2)
    true = moved(t, waves(t), inside).run.motion.thetadd
    noises = 1e-5 * rng.standard_normal((2, COUNT))
    blocks = [moved(t, waves(t) + noise, inside) for noise in noises]

    def off(same: bool) -> float:
        return float((swung(model_of(monkeypatch, blocks, same))[0].along - true).std())

    # of single runs nothing is known to be noise
    assert off(same=False) > 0.05 * true.std()
    assert off(same=True) < 0.3 * off(same=False)


@pytest.mark.parametrize("rest", [0.0, 0.2], ids=["waves", "rest"])
def test_run_begins_as_it_came(rest: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """The log of a motion that goes on for long, and of one that begins at rest."""
    t = np.linspace(-TS * LEAD, TS * COUNT, LEAD + COUNT, endpoint=False)
    fade = np.clip(t - rest, 0.0, 1.0) if rest else np.ones_like(t)
    theta = waves(t) * fade**3 * (10 - 15 * fade + 6 * fade**2)
    true = moved(t, theta, slice(2, -2)).run.motion.thetadd[:, 0]
    model = model_of(monkeypatch, [moved(t, theta, slice(LEAD, -2))], same=False)
    (own,) = swung(model)
    assert own.along[:, 0] == pytest.approx(true[LEAD - 2 :], abs=1e-6 * true.std())
    at = -own.apart * np.arange(len(own.before))[::-1]
    late = at > -1.0
    expected = np.interp(at[late], t[2:-2], true)
    assert own.before[late, 0] == pytest.approx(expected, abs=0.05 * true.std())


def test_state_at_the_start_is_that_of_what_came_before() -> None:
    """Of waves that go on it is their steady state, far from that of the first acceleration."""
    item = next(c for c in compiled(1) if c.effect.id == "flexible_mode")
    assert item.swings
    t, w, s = TS * np.arange(-COUNT, 1), 2 * np.pi * F, 2j * np.pi * 6.0
    pace = np.cos(2 * np.pi * 6.0 * t + 0.5)
    first = np.zeros(6)
    first[2] = pace[-1]
    (state,) = starts(
        item, np.array([F, ZETA]), 0, [first], [Swung(pace[:0, None], pace[:, None], TS)]
    )
    # e'' + 2 zeta w e' + w^2 e = -theta''
    steady = -np.exp(0.5j) / (s**2 + 2 * ZETA * w * s + w**2)
    assert state[0] == pytest.approx(steady.real, rel=0.02)
    assert state[1] == pytest.approx((s * steady).real, rel=0.02)
    assert abs(state[0]) > 1.5 * abs(pace[-1]) / w**2

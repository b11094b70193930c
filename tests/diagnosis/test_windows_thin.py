"""Columns of effects from as many samples as a mean over a window needs."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.runs.blocks import Block
from flexhex.diagnosis.runs.smoothing import enough, hann_weights

Array = NDArray[np.float64]
TS, WINDOW = 1e-3, 0.08


def block(every: int, valid: NDArray[np.bool_]) -> Block:
    at = np.arange(0.1, 3.9, 0.04)
    weights, filled = hann_weights(at, 0.0, TS, valid, WINDOW)
    some: Any = None
    return Block(some, at, weights, some, filled, filled[:, None], every)


@pytest.mark.parametrize(("broken", "close"), [(False, 1e-3), (True, 0.02)])
def test_third_of_the_samples_gives_the_same_mean(broken: bool, close: float) -> None:
    """Of a wave of 60 Hz, and of a jump, which falls between two samples of the thinned ones. A
    window that ends at a gap is cut off there at a sample."""
    t, valid = np.arange(0, 4, TS), np.ones(4000, dtype=bool)
    if broken:
        valid[2000:2050] = False
    whole, thin = block(1, valid), block(3, valid)
    wave = np.sin(2 * np.pi * 60 * t + t**2)
    jump = np.sign(t - 1.2345)
    for signal, error in ((wave, close), (jump, 0.1)):
        means = [b.few.smooth(b.few(signal)) for b in (whole, thin)]
        np.testing.assert_allclose(*(own[whole.usable] for own in means), atol=error)
    assert whole.usable.sum() > 90
    assert len(thin.few(signal)) < 0.4 * len(whole.few(signal))


def test_constant_stays_what_it_is() -> None:
    thin = block(3, np.ones(4000, dtype=bool))
    np.testing.assert_allclose(thin.few.smooth(thin.few(np.ones(4000))), 1.0, rtol=1e-12)


def test_noise_counts_no_more_than_in_all_samples() -> None:
    """A column of an acceleration is made of noise where encoders are coarse."""
    noise = np.random.default_rng(3).standard_normal(4000)
    whole, thin = (block(every, np.ones(4000, dtype=bool)) for every in (1, 3))
    means = [b.few.smooth(b.few(noise)) for b in (whole, thin)]
    assert float(np.std(means[1])) == pytest.approx(float(np.std(means[0])), rel=0.02)
    np.testing.assert_allclose(means[1], means[0], atol=0.2 * float(np.std(means[0])))


def test_fast_waves_need_more_samples() -> None:
    """At 2 rad/s a sample every 8 ms is two of each wave of 196 rad^-1."""
    turning: Any = SimpleNamespace(motion=SimpleNamespace(thetad=np.array([[0.1], [-2.0]]), ts=TS))
    thin = replace(block(8, np.ones(4000, dtype=bool)), run=turning)
    orders = (0.0, 195.0, 197.0, 392.0, 394.0, 784.0, 786.0, 1e5)
    assert [thin.halvings(0, order) for order in orders] == [0, 0, 1, 1, 2, 2, 3, 3]
    assert [thin.fewer(halvings).every for halvings in range(4)] == [8, 4, 2, 1]


def test_mean_of_neighbours_ends_at_a_gap() -> None:
    """What lies on the other side was measured elsewhere."""
    valid = np.ones(4000, dtype=bool)
    valid[2001:2100] = False
    thin = block(8, valid).few
    sides = np.where(np.arange(4000) < 2050, 0.0, 1.0)
    assert set(thin(sides).tolist()) == {0.0, 1.0}


def test_samples_of_a_window() -> None:
    assert [enough(window, TS) for window in (0.01, WINDOW, 0.5)] == [1, 3, 20]

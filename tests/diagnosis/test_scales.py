"""Shapes that the runs can tell: no mode is faster than what their smoothing lets through."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexhex.diagnosis.hypotheses.compiled import compiled
from flexhex.diagnosis.hypotheses.scales import Scales
from flexhex.fmus.filter.equations import hann
from tests.diagnosis.usual import usual


@pytest.fixture(scope="module")
def scales() -> Scales:
    """Of runs whose smoothing lets 12 Hz through."""
    effects = {item.effect.id: item for item in compiled(6)}
    return replace(usual(effects), fastest=12.0)


def test_modes_end_where_the_smoothing_lets_nothing_through(scales: Scales) -> None:
    f = scales.ranges("flexible_mode", 0)["f"]
    assert f.high == 12.0
    assert max(f.grid) <= 12.0 < 1.1 * max(f.grid)
    # and begin at the slowest that has the name
    assert min(f.grid) < 1.1 * f.low
    assert scales.possible("flexible_mode", 0, {"f": 11.0, "zeta": 0.02})
    assert not scales.possible("flexible_mode", 0, {"f": 13.0, "zeta": 0.02})


def test_two_periods_within_the_window_are_smoothed_away() -> None:
    """The first zero of the window's weights; one period keeps half of its size."""
    weights = hann(2001)
    t = np.linspace(-0.5, 0.5, len(weights))
    kept = [weights @ np.cos(2 * np.pi * periods * t) / weights.sum() for periods in (1, 2)]
    assert kept == pytest.approx([0.5, 0.0], abs=2e-3)

"""How much products of passes vary by chance where slow noise counts as white."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.signal import lfilter

from flexhex.diagnosis.runs.noise import measured, unweighted
from flexhex.diagnosis.runs.run import TimeSeries

KEPT, ROWS, TRIALS = 0.9, 400, 2000
"""Share of slow noise that is left a row later."""


def slow(rng: np.random.Generator, count: int) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Noise (count, ROWS) of unit variance."""
    raw = rng.standard_normal((count, ROWS + 100))
    return np.asarray(lfilter([np.sqrt(1 - KEPT**2)], [1, -KEPT], raw, axis=1)[:, 100:])


def test_products_of_slow_noise_vary_more() -> None:
    rng = np.random.default_rng(5)
    traces = slow(rng, 40)[:, :, None]
    signal = TimeSeries(0.0, 1e-3, np.full((ROWS, 1), 1e-3), np.ones(ROWS, bool))
    blocks: Any = [
        SimpleNamespace(
            run=SimpleNamespace(repeated=k // 2, tau=signal), judged=np.ones((ROWS, 1), bool)
        )
        for k in range(len(traces))
    ]
    noise = measured(blocks, list(traces))
    assert noise.chance[0] == 1.0  # whitened
    a, b = slow(rng, TRIALS), slow(rng, TRIALS)
    spread = (a * b).sum(axis=1).std() / np.sqrt(ROWS)
    white = unweighted(noise, np.array([True]))
    assert white.chance[0] == pytest.approx(spread, rel=0.1)
    assert replace(white, correlated=np.ones(1)).chance[0] == 1.0

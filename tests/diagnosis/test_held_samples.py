"""Passes of an arm whose logger holds samples: smoothed for longer, and then not doubted."""

from __future__ import annotations

import numpy as np
import pytest

from flexhex.diagnosis.basemodels.bases import base_of
from flexhex.diagnosis.jointfit.smoothed import fitted
from flexhex.diagnosis.logs import Channel, Log
from flexhex.diagnosis.runs.differences import motion_of
from flexhex.diagnosis.runs.pairing import doubtful
from flexhex.diagnosis.runs.run import Run, TimeSeries
from tests.conftest import ROOT
from tests.diagnosis.two_links import NOISE, TS, moved, torque

EXAMPLE = f"{ROOT / 'flexhex/init/two_links.py'}:TwoLinks"
CLOCK = np.arange(6000) * TS
EVERY, SHORT = 20, 8
"""Samples after which one is taken twice, and how many come late then."""


def run(seed: int, number: int, late: float) -> Run:
    """A pass of a motion, of which some samples are from a time [s] before; another part of them in
    every pass."""
    rng = np.random.default_rng([seed, number])
    held = (np.arange(len(CLOCK)) + rng.integers(EVERY)) % EVERY < SHORT
    motion = moved(CLOCK, seed)
    angles, rates, _ = moved(np.where(held, CLOCK - late, CLOCK), seed)
    valid = np.ones(len(CLOCK), dtype=bool)
    seen = motion_of(TimeSeries(0.0, TS, angles, valid), Channel(0.0, TS, rates, valid))
    tau = torque(motion, 0.0, (0.0, 0.0)) + NOISE * rng.standard_normal(angles.shape)
    signal = TimeSeries(0.0, TS, tau, valid)
    return Run(f"{seed}_{number}", str(seed), seen, valid[2:-2], signal)


@pytest.mark.parametrize("late", [0.0, 4 * TS])
def test_held_samples_are_smoothed_over_where_passes_repeat_too(late: float) -> None:
    base = base_of(EXAMPLE, None, Log.of("run.csv", TS, *np.ones((2, 10, 2))))
    runs = [run(seed, number, late) for seed in (1, 2) for number in (1, 2)]
    model, _, text = fitted(base, runs)
    assert ("that its torque does not show" in text) == (late > 0)
    assert (model.base.window > base.window) == (late > 0)
    assert bool(doubtful(base, runs)) == (late > 0)
    assert doubtful(model.base, runs) == ""

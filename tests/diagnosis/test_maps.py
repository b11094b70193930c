"""Maps of what a model leaves: cogging of a high order is seen over the angle."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from flexhex.diagnosis.hypotheses.candidates import Bench
from flexhex.diagnosis.jointfit.smoothed import fitted
from flexhex.diagnosis.prepare import Options, run_set_of
from flexhex.diagnosis.result.maps import BINS, FINEST, maps
from flexhex.diagnosis.result.pictured import Map
from tests.diagnosis.single import SECONDS, TS, moved, write

COGGING, ORDER = 0.05, 100.0
"""Amplitude [N m] and order [1/rad]: some 13 waves over the range of a motion."""


def left(paths: list[Path], *parts: Any) -> dict[str, Map]:
    """Maps of the residual of a fit without any effect, by quantity; parts: what is told of it."""
    base, run_set, _ = run_set_of(paths, [], None, Options("axis"))
    model, _, _ = fitted(base, run_set.runs)
    bench = Bench(model, ())
    fit: Any = SimpleNamespace(
        bench=bench, residual=model.residual(model.regression.q), parts=parts
    )
    return {one.over: one for one in maps(fit)}


def test_cogging_of_a_high_order_is_seen_over_the_angle(tmp_path: Path) -> None:
    """With the 24 bins of the other maps, each would hold half a wave or more."""
    paths = []
    for seed in (1, 2):
        theta = moved(np.arange(round(SECONDS / TS)) * TS, seed)[0]
        extra = COGGING * np.sin(ORDER * theta)
        for number in (1, 2):
            paths.append(write(tmp_path / f"{seed}{number}.csv", seed, number, 0.0, extra=extra))
    drawn = left(paths)
    angle = drawn["angle"]
    assert BINS < len(angle.centre) <= FINEST
    assert len(drawn["velocity"].centre) <= BINS
    rows = np.diff(angle.centre)
    assert np.median(rows) * ORDER < 2 * np.pi / 6, "six bins a wave or more"
    # what the smoothing of the torque leaves of it, and noise that the mean of a bin takes away
    wave = np.column_stack([np.sin(ORDER * angle.centre), np.cos(ORDER * angle.centre)])
    gains, *_ = np.linalg.lstsq(wave, angle.before, rcond=None)
    assert 0.5 * COGGING < np.hypot(*gains) < COGGING
    assert np.std(angle.before - wave @ gains) < 0.5 * np.std(angle.before)


def test_wave_that_was_found_has_bins_enough_to_be_seen(tmp_path: Path) -> None:
    """In short runs, too, whose bins would be as wide as the wave is long."""
    paths = [write(tmp_path / f"{n}.csv", 3, n, 0.1, seconds=12.0) for n in (1, 2)]
    usual = left(paths)["angle"].centre
    order = 2 * np.pi / np.median(np.diff(usual))
    wave = SimpleNamespace(id="cogging_harmonic", axis=0, shape={"order": order})
    finer = left(paths, wave)["angle"].centre
    assert np.median(np.diff(finer)) * order < 2 * np.pi / 6
    other = SimpleNamespace(id="cogging_harmonic", axis=1, shape={"order": order})
    assert len(left(paths, other)["angle"].centre) == len(usual)


def test_few_rows_make_no_finer_bins(tmp_path: Path) -> None:
    """Of 700 rows, 240 bins would hold three each, and most would not be shown."""
    paths = [write(tmp_path / f"{n}.csv", 3, n, 0.1, seconds=4.0) for n in (1, 2)]
    drawn = left(paths)
    assert BINS / 2 < len(drawn["angle"].centre) <= BINS

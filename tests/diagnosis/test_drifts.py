"""A torque that creeps from run to run is named with its rate; slow noise is none."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.result.verdict import Diagnosis
from flexhex.diagnosis.workflow import Options, diagnose
from tests.diagnosis.single import SECONDS, TS, wandering, wanted, write

OPTIONS = Options(base="axis")
RUNS = ((1, 1), (1, 2), (2, 1), (2, 2), (3, 1), (3, 2))
"""Motion and pass of each run, in the order of time; the last motion is judged on."""
CREEP, TIME = 1e-3, 25.0
"""Of a torque that creeps in: at first [N m/s], until it rests [s]."""
COUNT = round(SECONDS / TS)
RMS = float(wanted(TS * np.arange(COUNT), 1).std())


def said(folder: Path, extra: list[NDArray[np.float64]]) -> Diagnosis:
    """The answer for runs with a torque more, one after the other."""
    paths = [
        write(folder / f"{k}.csv", *run, 0.0, extra=torque, run=k)
        for k, (run, torque) in enumerate(zip(RUNS, extra, strict=True), start=1)
    ]
    return diagnose(paths[:4], paths[4:], options=OPTIONS)


def creeping(held_out: int = COUNT) -> list[NDArray[np.float64]]:
    """Of each run, one after the other; the last two end after so many samples."""
    starts = [*(k * COUNT for k in range(5)), 4 * COUNT + held_out]
    clocks = [TS * (start + np.arange(COUNT)) for start in starts]
    return [CREEP * TIME * (1 - np.exp(-clock / TIME)) for clock in clocks]


def test_creeping_offset_is_named_with_its_rate(tmp_path: Path) -> None:
    """1 % of the torque; whitened it is not a tenth of that."""
    (drift,) = said(tmp_path, creeping()).effects
    assert drift.id == "offset_drift"
    rate, time = (drift.parameters[name] for name in ("o_r", "T"))
    assert rate.ci95[0] < CREEP < rate.ci95[1]
    assert rate.value == pytest.approx(CREEP, rel=0.25)
    assert time.value == pytest.approx(TIME, rel=0.3)


@pytest.mark.sample(1)
@pytest.mark.parametrize("corner", [0.05, 0.5, 5.0])
def test_slow_noise_is_no_drift(tmp_path: Path, corner: float) -> None:
    rng = np.random.default_rng(11)
    diagnosis = said(tmp_path, [0.02 * wandering(COUNT, corner, rng) for _ in RUNS])
    assert diagnosis.effects == ()


@pytest.mark.sample(1)
@pytest.mark.parametrize("seed", [1, 12])
def test_random_walk_is_no_drift(tmp_path: Path, seed: int) -> None:
    """Of 2 % of the torque at the end of all runs; the second one looks like a straight line."""
    steps = np.random.default_rng([seed, 5]).standard_normal(len(RUNS) * COUNT)
    walk = 0.02 * RMS * np.cumsum(steps) / np.sqrt(len(steps))
    diagnosis = said(tmp_path, list(walk.reshape(len(RUNS), COUNT)))
    assert diagnosis.effects == ()


def test_drift_is_judged_on_short_held_out_runs(tmp_path: Path) -> None:
    """Enough for the mechanism, too little of what is smoothed as far as the other runs allow."""
    short = COUNT // 3
    paths = [
        write(tmp_path / f"{k}.csv", *run, 0.0, extra=torque, run=k)
        for k, (run, torque) in enumerate(zip(RUNS, creeping(short), strict=True), start=1)
    ]
    for path in paths[4:]:
        lines = path.read_text().splitlines(keepends=True)
        path.write_text("".join(lines[: short + len(lines) - COUNT]))
    diagnosis = diagnose(paths[:4], paths[4:], options=OPTIONS)
    assert [effect.id for effect in diagnosis.effects] == ["offset_drift"]

"""What changes during a run, of an axis: named in proportion to the run's length, and on one
trajectory not denied."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexhex.diagnosis.workflow import Options, diagnose
from tests.diagnosis.single import TS, wanted, write

OPTIONS = Options(base="axis")
LOST, LATE = 0.15, 2e-3


@pytest.mark.parametrize("seconds", [2.0, 12.0])
def test_motor_that_gets_warm_within_a_run_is_named(seconds: float, tmp_path: Path) -> None:
    """The torque constant falls with a time constant as long as the run: all that is lost in the
    end would be impossible if the time constant of the short one were much longer."""
    clock, paths = np.arange(round(seconds / TS)) * TS, list[Path]()
    for seed, number in ((1, 1), (1, 2), (2, 1), (2, 2)):
        lost = LOST * (1 - np.exp(-clock / seconds))
        more = lost / (1 - lost) * wanted(clock, seed)
        name = tmp_path / f"{seed}_{number}.csv"
        paths.append(write(name, seed, number, 0.0, extra=more, seconds=seconds))
    (effect,) = diagnose(paths, options=OPTIONS).effects
    assert effect.id == "thermal_drift"
    low, high = effect.parameters["g_t"].ci95
    assert low < LOST < high


def warmed(folder: Path, run: int, seed: int, lost: float) -> Path:
    """A run of several, one after the other, of a motor that loses so much of its torque constant
    in the end; torque is reported late, too."""
    clock = np.arange(12000) * TS
    cold = lost * (1 - np.exp(-(clock + 12.0 * (run - 1)) / 60.0))
    more = wanted(clock - LATE, seed) / (1 - cold) - wanted(clock, seed)
    return write(folder / f"{run}.csv", seed, run, 0.0, extra=more, run=run)


@pytest.mark.parametrize("lost", [0.03, 0.1])
def test_motor_that_gets_warm_from_run_to_run_is_named(lost: float, tmp_path: Path) -> None:
    """Beside what a large drift leaves, the delay explains next to nothing, and what that makes
    repeats."""
    paths = [warmed(tmp_path, run, (run + 2) // 3, lost) for run in range(1, 7)]
    diagnosis = diagnose(paths, options=OPTIONS)
    (effect,) = diagnosis.effects
    assert (diagnosis.verdict, effect.id) == ("named", "thermal_drift")
    low, high = effect.parameters["T"].ci95
    assert low < 60.0 < high


@pytest.mark.parametrize("lost", [0.03, -0.03])
def test_drift_that_makes_a_held_out_run_worse_is_none(lost: float, tmp_path: Path) -> None:
    """The next run goes on with it, or against it."""
    paths = [warmed(tmp_path, run, (run + 2) // 3, 0.03) for run in range(1, 7)]
    held_out = [warmed(tmp_path, 7, 3, lost)]
    effects = [effect.id for effect in diagnose(paths, held_out, options=OPTIONS).effects]
    assert effects == (["thermal_drift"] if lost > 0 else [])


def test_creep_on_one_trajectory_is_not_denied(tmp_path: Path) -> None:
    """Two passes creep alike: an effect of the library would fit, and nothing confirms it."""
    creep = 0.03 * (1 - np.exp(-np.arange(12000) * TS / 12))
    paths = [write(tmp_path / f"{k}.csv", 1, k, 0.0, extra=creep) for k in (1, 2)]
    diagnosis = diagnose(paths, options=OPTIONS)
    assert diagnosis.verdict == "cannot tell"
    assert any("one trajectory cannot show it" in note for note in diagnosis.notes)

"""Passes inside one long log: found where a motion repeats, and only there."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.logs.cycles import cycles, with_cycles
from flexhex.diagnosis.logs.groups import group_runs
from flexhex.diagnosis.logs.log import Log
from flexhex.diagnosis.prepare import Options, run_set_of
from tests.compare import assert_close

Array = NDArray[np.float64]
TS = 1e-3


def repeated(t: Array, period: float, seed: int = 1) -> Array:
    """A motion (samples, 2) that comes again after a period."""
    rng = np.random.default_rng(seed)
    orders, phase = np.array([1, 2, 3, 5, 8]), rng.uniform(0, 2 * np.pi, (2, 5))
    waves = np.sin(2 * np.pi / period * orders * t[:, None, None] + phase)
    return np.asarray(waves @ (0.5 / orders))


def log(theta: Array, name: str = "long.csv", noise: float = 1e-5, start: float = 0.0) -> Log:
    rng = np.random.default_rng(3)
    seen = theta + noise * rng.standard_normal(theta.shape)
    built = Log.of(name, TS, seen, rng.standard_normal(theta.shape))
    late = {key: type(c)(start, c.ts, c.values, c.valid) for key, c in built.channels.items()}
    return Log(name, late, {"pass": "1", "trajectory": "a"})


def clock(seconds: float) -> Array:
    return np.arange(round(seconds / TS)) * TS


@pytest.mark.parametrize("period", [7.3, 6.00037])
def test_passes_begin_where_the_motion_comes_again(period: float) -> None:
    passes = cycles(log(repeated(clock(4.4 * period), period), start=5.0))
    assert [part.name for part in passes] == [f"long.csv, pass {k}" for k in (1, 2, 3, 4)]
    starts = [part["theta"].t0 for part in passes]
    # cut at samples: each begins within one after its due time
    assert_close(np.array(starts) - 5.0, np.arange(4) * period, atol=1.01 * TS)
    assert [str(note) for part in passes for note in part.findings] == [
        f"long.csv: its motion repeats: 4 passes of {period:.4g} s are taken from it"
    ]
    assert all("pass" not in part.meta and part.meta["trajectory"] == "a" for part in passes)


def test_what_passes_leave_over_is_not_taken_twice() -> None:
    whole = log(repeated(clock(20.0), 8.0))
    passes = cycles(whole)
    assert len(passes) == 2
    joined = np.concatenate([part["theta"].values for part in passes])
    assert np.array_equal(joined, whole["theta"].values[: len(joined)])


def test_short_cycles_stay_together() -> None:
    passes = cycles(log(repeated(clock(13.0), 1.0)))
    assert len(passes) == 3
    lengths = np.array([len(part["theta"].values) for part in passes])
    assert_close(lengths * TS, np.full(3, 4.0), atol=1.5 * TS)


def eased(t: Array, length: float, seed: int) -> Array:
    """A motion that begins and ends at rest in zero."""
    fade = np.clip(np.minimum(t, length - t) / 0.5, 0.0, 1.0)[:, None]
    return np.asarray(fade**2 * (3 - 2 * fade) * repeated(t, 1.7 * length, seed))


def starts_and_lengths(passes: list[Log]) -> Array:
    spans = [(part["theta"].t0, TS * len(part["theta"].values)) for part in passes]
    return np.array(spans)


def test_each_of_several_motions_has_its_passes() -> None:
    """One after the other: a log begins with what does not repeat, and ends in a part of a pass."""
    pieces = [
        repeated(clock(3.0), 50.0, 4),
        np.tile(eased(clock(6.0), 6.0, 1), (4, 1)),
        np.tile(eased(clock(7.5), 7.5, 2), (3, 1)),
        eased(clock(2.0), 7.5, 2),
    ]
    passes = cycles(log(np.concatenate(pieces)))
    wanted = [*([3.0 + 6.0 * k, 6.0] for k in range(4)), *([27.0 + 7.5 * k, 7.5] for k in range(3))]
    found = starts_and_lengths(passes)
    # where one begins is told by where it rests, and ends where its last pass does
    assert_close(found, np.array(wanted), atol=0.6)
    assert_close(np.diff(found[:4, 0]), np.full(3, 6.0), atol=5 * TS)
    assert_close(np.diff(found[4:, 0]), np.full(2, 7.5), atol=5 * TS)
    assert len(group_runs(passes)) == 2
    texts = [str(note) for part in passes for note in part.findings]
    assert [text.rpartition(": ")[2] for text in texts] == [
        f"{count} passes are taken from it" for count in (4, 3)
    ]
    assert all("trajectory" not in part.meta for part in passes)


@pytest.mark.parametrize(("rest", "motions"), [(1.0, 2), (0.2, 1)])
def test_motions_in_turn_are_told_apart_by_rests(rest: float, motions: int) -> None:
    still = np.zeros((round(rest / TS), 2))
    both = [eased(clock(6.0), 6.0, 1), still, eased(clock(7.0), 7.0, 2), still]
    passes = cycles(log(np.tile(np.concatenate(both), (3, 1))))
    assert len(passes) == 3 * motions
    assert len(group_runs(passes)) == motions


def test_short_moves_with_rests_are_one_motion() -> None:
    still = np.zeros((1000, 2))
    moves = [np.concatenate([eased(clock(1.5), 1.5, seed), still]) for seed in range(3)]
    passes = cycles(log(np.tile(np.concatenate(moves), (3, 1))))
    assert len(passes) == 3
    assert len(group_runs(passes)) == 1


UNIQUE = {
    "no two alike": lambda t: np.sin(np.outer(t, (1.1, 2.7))) + np.sin(np.outer(t, (3.9, 0.7))),
    "slow": lambda t: np.sin(2 * np.pi * t / 200.0)[:, None] * np.ones(2),
    "once and a half": lambda t: repeated(t, 20.0),
    "still": lambda t: np.zeros((len(t), 2)),
    "larger each time": lambda t: (1 + 0.012 * t[:, None]) * repeated(t, 10.0),
    "decaying": lambda t: np.exp(-t / 10)[:, None] * repeated(t, 5.0),
}


@pytest.mark.parametrize("case", UNIQUE)
def test_other_motions_stay_in_one_piece(case: str) -> None:
    one = log(UNIQUE[case](clock(30.0)))
    assert cycles(one) == [one]


def test_logs_that_are_passes_of_each_other_stay_whole() -> None:
    pair = [log(repeated(clock(16.0), 8.0), name) for name in ("a.csv", "b.csv")]
    assert with_cycles(pair) == pair


def test_two_long_logs_are_two_trajectories_with_passes(tmp_path: Path) -> None:
    paths = []
    for seed, period in ((1, 6.0), (2, 7.0)):
        t = clock(3.2 * period)
        theta = repeated(t, period, seed)[:, :1]
        tau = np.gradient(np.gradient(theta[:, 0], TS), TS)
        paths.append(tmp_path / f"{seed}.csv")
        rows = np.column_stack([t, theta, tau])
        head = "time,theta[1],tau_meas[1]\ns,rad,N m"
        np.savetxt(paths[-1], rows, delimiter=",", header=head, comments="", fmt="%.9g")
    _, run_set, trouble = run_set_of(paths, (), None, Options("axis"))
    assert trouble == ""
    assert len(run_set.runs) == 6
    assert len({run.trajectory for run in run_set.runs}) == 2
    assert run_set.names == (tuple(map(str, paths)), ())
    assert not any("one pass only" in text for text in run_set.findings)

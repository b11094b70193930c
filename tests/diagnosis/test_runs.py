"""Broken logs as runs: each piece is judged with the piece of the other pass that lies on it."""

from __future__ import annotations

import numpy as np

from diagnosis.blocks import Run
from diagnosis.logs import Channel, Log, RunGroup
from diagnosis.runs import runs_of

TS = 1e-3


def log(name: str, breaks: tuple[tuple[int, float], ...] = (), samples: int = 9000) -> Log:
    """A log of one axis; breaks as a channel has them."""
    values = np.sin(np.arange(samples) * TS)[:, None]
    channel = Channel(0.0, TS, values, np.ones(samples, dtype=bool), breaks)
    return Log(name, {"theta": channel, "tau_meas": channel})


def parts(*logs: Log) -> dict[str, list[str]]:
    """Names of the logs by trajectory."""
    found: dict[str, list[str]] = {}
    run: Run
    for run in runs_of([RunGroup("a", logs)], 1):
        found.setdefault(run.trajectory, []).append(run.name)
    return found


def test_whole_logs_are_passes_of_their_trajectory() -> None:
    assert parts(log("x"), log("y")) == {"a": ["x", "y"]}


def test_stretches_of_long_logs_meet_their_like() -> None:
    """Read in stretches because they were too long for the memory: equal times in both."""
    breaks = (3000, 60.0), (6000, 60.0)
    assert parts(log("x", breaks), log("y", breaks)) == {
        f"a, part {k}": ["x", "y"] for k in (1, 2, 3)
    }


def test_piece_that_no_other_pass_has_stands_alone() -> None:
    found = parts(log("x"), log("y", ((4000, 0.5),)))
    assert found == {"a, part 1": ["x", "y"], "a, part 2": ["y"]}


def test_scrap_behind_a_break_is_left_out() -> None:
    assert parts(log("x", ((8500, 0.5),)), log("y")) == {"a": ["x", "y"]}

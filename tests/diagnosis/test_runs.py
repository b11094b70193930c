"""Broken logs as runs: each piece is judged with the piece of the other pass that lies on it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from flexhex.diagnosis.basemodels.bases import base_of
from flexhex.diagnosis.logs import Channel, Log, RunGroup
from flexhex.diagnosis.prepare import Options, run_set_of
from flexhex.diagnosis.runs.run import Run
from flexhex.diagnosis.runs.runs import refuse_slow, runs_of, starts_of
from flexhex.fmus.common.errors import LogError
from tests.conftest import MACHINE_FILE
from tests.diagnosis import two_links
from tests.diagnosis.synthetic import plain_csv

TS = 1e-3


def log(name: str, breaks: tuple[tuple[int, float], ...] = (), samples: int = 9000) -> Log:
    """A log of one axis; breaks as a channel has them."""
    values = np.sin(np.arange(samples) * TS)[:, None]
    channel = Channel(0.0, TS, values, np.ones(samples, dtype=bool), breaks)
    return Log(name, {"theta": channel, "tau_meas": channel})


def parts(*logs: Log) -> dict[str, list[str]]:
    """Names of the logs by trajectory."""
    names: dict[str, list[str]] = {}
    run: Run
    for run in runs_of([RunGroup("a", logs)], 1):
        names.setdefault(run.trajectory, []).append(run.name)
    return names


def test_whole_logs_are_passes_of_their_trajectory() -> None:
    assert parts(log("x"), log("y")) == {"a": ["x", "y"]}


def test_stretches_of_long_logs_meet_their_like() -> None:
    """Read in stretches because they were too long for the memory: equal times in both."""
    breaks = (3000, 60.0), (6000, 60.0)
    assert parts(log("x", breaks), log("y", breaks)) == {
        f"a, part {k}": ["x", "y"] for k in (1, 2, 3)
    }


def test_piece_that_no_other_pass_has_stands_alone() -> None:
    result = parts(log("x"), log("y", ((4000, 0.5),)))
    assert result == {"a, part 1": ["x", "y"], "a, part 2": ["y"]}


def test_scrap_behind_a_break_is_left_out() -> None:
    assert parts(log("x", ((8500, 0.5),)), log("y")) == {"a": ["x", "y"]}


def starts(*runs: tuple[int, str | None]) -> list[float]:
    """When logs of so many seconds, with these numbers, began [s]."""
    listed = [
        replace(log(str(k), samples=1000 * seconds), meta={"run": run} if run else {})
        for k, (seconds, run) in enumerate(runs)
    ]
    return [round(start, 6) for start in starts_of(listed).values()]


def test_runs_begin_where_those_before_them_end() -> None:
    assert starts((9, "1"), (9, "2"), (4, "3"), (4, "4")) == [0, 9, 18, 22]


def test_missing_runs_were_as_long_as_the_next_one() -> None:
    assert starts((9, "2"), (4, "5")) == [9, 26]


def test_numbers_far_apart_are_labels() -> None:
    assert starts((9, "20261121"), (4, "20261122")) == [0, 9]


def test_without_numbers_runs_follow_as_they_were_named() -> None:
    assert starts((9, None), (4, "1")) == [0, 9]
    assert starts((9, "1"), (4, "1")) == [0, 9]


def test_log_of_another_number_of_axes_is_refused_before_the_model_is_compiled() -> None:
    with pytest.raises(LogError, match="x: theta has 1 axis, the model has 6: add --base"):
        base_of("hexapod", MACHINE_FILE, log("x"))
    # of any other base model --base was given
    with pytest.raises(LogError, match="has 1 axis, the model has 2: is it of the machine that"):
        log("x").refuse_width(2)


def test_same_finding_in_many_logs_is_one_line_with_the_range_of_its_figures(
    tmp_path: Path,
) -> None:
    paths = []
    for number, turn in ((1, 50.0), (2, 70.0), (3, 60.0)):
        run = two_links.run(1, number, 0.0, (0.0, 0.0))
        run["theta"] += [turn, 0.0]
        paths.append(plain_csv(tmp_path / f"{number}.csv", run, trajectory="1"))
    _, run_set, _ = run_set_of(paths, [], None, Options(base="axis"))
    (text,) = [each for each in run_set.findings if "reaches" in each]
    low, high = (float(word.rstrip(":")) for word in text.split("reaches ")[1].split()[:3:2])
    assert "1.csv and 2 more: theta[1] reaches" in text
    assert 49.0 < low < 53.0 < 69.0 < high < 73.0


def test_file_with_times_in_another_unit_is_named(tmp_path: Path) -> None:
    """Of several only one is wrong; the others would be too short beside it."""
    rows, paths = two_links.run(1, 1, 0.0, (0.0, 0.0)), []
    for name, scale in (("a", 1.0), ("b", 1e3)):
        paths.append(tmp_path / f"{name}.csv")
        columns = [scale * rows["time"], rows["theta"], rows["tau_meas"]]
        head = "time,theta[1],theta[2],tau_meas[1],tau_meas[2]\ns,rad,rad,N m,N m"
        np.savetxt(paths[-1], np.column_stack(columns), delimiter=",", header=head, comments="")
    with pytest.raises(LogError, match=r"b\.csv: samples are 2 s apart.*time=ms"):
        run_set_of(paths, [], None, Options("axis"))


def test_twenty_samples_a_second_are_enough() -> None:
    refuse_slow(Log.of("a", 0.05, *np.ones((2, 10, 1))))
    with pytest.raises(LogError, match=r"at most 0\.05 s"):
        refuse_slow(Log.of("a", 0.06, *np.ones((2, 10, 1))))

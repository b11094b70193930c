"""Progress: estimates, lines in a pipe, bars that vanish, an end for what runs in other threads."""

from __future__ import annotations

import io
import re
import threading

import pytest
from rich.console import Console

from flexhex.output.bars import Bars
from flexhex.output.lines import EVERY, Lines
from flexhex.output.progress import CancelledError, Progress, Task, clock_time
from flexhex.simulation.cases import Case
from flexhex.simulation.runs import side_by_side


class Clock:
    """A clock that is set by hand [s]."""

    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


def test_time_left_goes_on_as_it_went() -> None:
    task = Task("a", 40.0, "s simulated", began=0.0, done=10.0)
    assert task.left(6.0) == pytest.approx(18.0)
    assert task.state(6.0) == "10 of 40 s simulated, about 18 s left"
    assert task.left(0.5) is None, "too soon"
    assert Task("a", 0.0, "", 0.0, note="estimator").state(75.0) == "estimator, 1 min 15 s so far"
    assert clock_time(59.6) == "1 min 00 s"


def test_pipe_gets_a_line_for_a_stage_and_one_every_few_seconds() -> None:
    stream, clock = io.StringIO(), Clock()
    progress = Lines(stream, clock)
    progress.stages = 2
    progress.stage("simulating", 100.0)
    advance = progress.case(Case("a", "the case", "plant", 50.0))
    for _ in range(40):
        clock.now += EVERY / 10
        advance((clock.now - 100.0) * 2, 50.0)
        progress.tick()
    lines = stream.getvalue().splitlines()
    assert lines[0] == "flexhex: [1/2] simulating"
    assert lines[1] == "flexhex: [1/2] simulating: 10 of 100 s simulated, about 45 s left"
    assert len(lines) == 1 + 4


def test_note_stays_on_a_pipe_and_above_the_bars() -> None:
    stream = io.StringIO()
    Lines(stream, Clock()).note("in doubt")
    assert stream.getvalue() == "flexhex: in doubt\n"
    console = Console(file=io.StringIO(), force_terminal=True, width=20)
    with Bars(console) as bars:
        bars.note("longer than the terminal is wide")
    assert "longer than the terminal is wide" in console.file.getvalue()


def test_pipe_gets_no_line_where_nothing_went_on() -> None:
    """Else a log fills with lines that differ in their time alone."""
    stream, clock = io.StringIO(), Clock()
    progress = Lines(stream, clock)
    progress.stage("fitting")
    for _ in range(10):
        clock.now += EVERY
        progress.tick()
    assert len(stream.getvalue().splitlines()) == 2, "the stage, and that it is under way"
    progress.building("plant")
    for _ in range(3):
        clock.now += EVERY
        progress.tick()
    said = stream.getvalue().splitlines()
    assert said[2:] == ["flexhex: fitting: building plant, 55 s so far"]


def test_simulations_side_by_side_add_up_to_their_stage() -> None:
    progress = Progress(Clock())
    progress.stage("simulating", 100.0)
    first, second = (progress.case(Case("a", "a", "plant", 50.0)) for _ in range(2))
    first(20.0, 50.0), second(10.0, 50.0), first(50.0, 50.0)
    assert progress._stage
    assert progress._stage.done == pytest.approx(60.0)


def test_fmus_of_a_build_count_once() -> None:
    """The variants of a system are built anew under the same names."""
    progress = Progress(Clock())
    progress.stage("building", 7, "FMUs")
    for name in ("plant", "filter", "plant"):
        progress.building(name)
    assert progress._stage
    assert (progress._stage.done, progress._stage.note) == (2, "plant")


def screen(text: str) -> str:
    """What a terminal shows after the text: cursor up, erase line, colours."""
    lines, row = [""], 0
    for part in re.findall(r"\x1b\[[0-9;?]*[A-Za-z]|\r|\n|[^\x1b\r\n]+", text):
        if part == "\n":
            row += 1
            lines += [""] * (row + 1 - len(lines))
        elif part == "\x1b[1A":
            row -= 1
        elif part == "\x1b[2K":
            lines[row] = ""
        elif not part.startswith(("\x1b", "\r")):
            lines[row] += part
    return "\n".join(line for line in lines if line.strip())


def test_nothing_stays_behind_an_error() -> None:
    stream = io.StringIO()
    console = Console(file=stream, force_terminal=True, width=80)

    def failing() -> None:
        with Bars(console) as progress:
            progress.stage("building")
            progress.stage("simulating", 10.0)
            progress.case(Case("a", "the case", "plant", 10.0))(5.0, 10.0)
            progress._live.refresh()
            assert "the case" in screen(stream.getvalue())
            raise ValueError("wrong")

    with pytest.raises(ValueError, match="wrong"):
        failing()
    assert screen(stream.getvalue()) == "✓ building (0 s)"


def test_pause_hides_the_bars_and_they_come_back() -> None:
    stream = io.StringIO()
    with Bars(Console(file=stream, force_terminal=True, width=80)) as progress:
        progress.stage("diagnosing")
        with progress.paused():
            assert "diagnosing" not in screen(stream.getvalue())
        progress._live.refresh()
        assert "diagnosing" in screen(stream.getvalue())


def test_first_error_ends_the_simulations_beside_it() -> None:
    """Without it the other one would go on to its end: Ctrl-C would wait for it."""
    progress, going = Progress(), threading.Event()
    finished: list[str] = []

    def one(name: str) -> None:
        if name == "fails":
            going.wait(10.0)
            raise ValueError(name)
        advance = progress.line(name, 1.0)
        going.set()
        for _ in range(1_000_000):
            advance(0.5, 1.0)
        finished.append(name)

    with pytest.raises(ValueError, match="fails"):
        side_by_side(["goes on", "fails"], one, progress)
    assert finished == []
    with pytest.raises(CancelledError):
        progress.line("later", 1.0)(0.1, 1.0)

"""Progress in a terminal: a line for each stage and bars for what runs now."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Self

from rich.console import Console, Group
from rich.live import Live
from rich.progress_bar import ProgressBar
from rich.spinner import Spinner
from rich.table import Table
from rich.text import Text

from flexhex.output.progress import Progress, Task, clock_time

BAR, SHORTEST = 20, 5
"""Characters of a bar: at most, and below which there is none."""


class Bars(Progress):
    """Draws on stderr. What is done stays as a line, what is under way vanishes at the end."""

    def __init__(self, console: Console | None = None) -> None:
        super().__init__(time.monotonic)
        self._spinner = Spinner("dots")
        self._live = Live(
            console=console or Console(stderr=True),
            get_renderable=self._drawn,
            refresh_per_second=8,
            transient=True,
        )

    def __enter__(self) -> Self:
        self._live.start()
        return self

    def _closed(self, well: bool) -> None:
        if well and self._stage is not None:
            self._ended(self._stage)
        self._stage, self._tasks = None, []
        self._live.stop()

    def note(self, text: str) -> None:
        """A line above the bars."""
        self._live.console.print(text, markup=False, highlight=False, soft_wrap=True)

    @contextmanager
    def paused(self) -> Iterator[None]:
        """The bars vanish meanwhile."""
        self._live.stop()
        yield
        self._live.start()

    def _ended(self, task: Task) -> None:
        spent = self.clock() - task.began
        stage = task is self._stage
        indent = "" if stage else "  "
        speed = "" if stage or not spent else f", {task.total / spent:.1f} × real time"
        speed = speed if task.unit == "s simulated" else ""
        text = f"{indent}✓ {self.titled(task)} ({clock_time(spent)}{speed})"
        self._live.console.print(text, markup=False, highlight=False, soft_wrap=True)

    def _drawn(self) -> Group:
        """One line for the stage, one for each simulation."""
        with self._lock:
            now = self.clock()
            rows = [self._row(task, now) for task in (self._stage, *self._tasks) if task]
        return Group(*rows)

    def _row(self, task: Task, now: float) -> Table:
        """Spinner, bar and text; the bar takes the room that the text leaves."""
        indent = "" if task is self._stage else "  "
        text = f"{indent}{self.titled(task)}: {task.state(now)}"
        room = min(BAR, self._live.console.width - len(text) - 4)
        row = Table.grid(padding=(0, 1))
        bar = ProgressBar(task.total or 1.0, task.done, room, pulse=not task.total)
        row.add_row(self._spinner, *([bar] if room >= SHORTEST else []), Text(text))
        return row

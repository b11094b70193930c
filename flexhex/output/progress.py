"""Progress of long commands: what is done, and an estimate of the time left.

`flexhex.output.live` shows it on stderr: bars in a terminal, elsewhere a line every few seconds.
Nothing of it stays behind when the command ends, is stopped or fails.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from types import TracebackType
from typing import Protocol, Self

Advance = Callable[[float, float], None]
"""Called with what is done and the whole, in the same unit."""
SOON = 1.0
"""Time before which nothing is estimated, and the least that is said to be left [s]."""
UNEVEN = ("steps", "FMUs")
"""Units that take very different times: how many are done says little of the time left."""


class Planned(Protocol):
    """A run whose progress is shown: its title, and how long it will last [s]."""

    @property
    def title(self) -> str:
        """What the run is."""

    @property
    def duration(self) -> float:
        """Simulated time [s]."""


class CancelledError(Exception):
    """Raised inside a computation of a command that was stopped or failed elsewhere."""


@dataclass
class Task:
    """Something under way. total: 0 where it is not known; unit: of total and done."""

    text: str
    total: float
    unit: str
    began: float
    done: float = 0.0
    note: str = ""

    def left(self, now: float) -> float | None:
        """Estimate of the time left [s], as fast as it went so far."""
        spent = now - self.began
        if not self.total or not self.done or spent < SOON or self.unit in UNEVEN:
            return None
        return spent * max(self.total - self.done, 0.0) / self.done

    def state(self, now: float) -> str:
        """`104 of 364 s simulated, about 40 s left`, after the note if there is one."""
        parts = [self.note] if self.note else []
        if self.total:
            parts.append(f"{self.done:.0f} of {self.total:.0f} {self.unit}")
        left = self.left(now)
        parts.append(
            f"{clock_time(now - self.began)} so far"
            if left is None
            else f"about {clock_time(max(left, SOON))} left"
        )
        return ", ".join(parts)


def clock_time(seconds: float) -> str:
    """`48 s`, `3 min 20 s`."""
    whole = round(seconds)
    return f"{whole} s" if whole < 60 else f"{whole // 60} min {whole % 60:02d} s"


class Progress:
    """What a long computation reports while it goes on; this one shows nothing.

    stages: how many there will be, if known. Safe to be called from several threads.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self.clock = clock
        self.stages = 0
        self._number = 0
        self._stage: Task | None = None
        self._tasks: list[Task] = []
        self._built: set[str] = set()
        self._cancelled = False
        self._lock = threading.RLock()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if error is not None:
            self.cancel()
        self._closed(error is None)

    def stage(self, text: str, total: float = 0.0, unit: str = "s simulated") -> None:
        """A new stage begins, the one before is done. total: of the simulations within it."""
        with self._lock:
            if self._stage is not None:
                self._ended(self._stage)
            self._number += 1
            self._built = set()
            self._stage = Task(text, total, unit, self.clock())
            self._begun(self._stage)

    def building(self, text: str) -> None:
        """The build of an FMU begins within the stage."""
        with self._lock:
            if self._stage is not None:
                counted = self._stage.unit == "FMUs"
                self._built.add(text)
                self._stage.note = text if counted else f"building {text}"
                self._stage.done = len(self._built) if counted else self._stage.done

    def case(self, case: Planned) -> Advance:
        """A simulation begins."""
        return self.line(case.title, case.duration)

    def line(self, text: str, total: float, unit: str = "s simulated") -> Advance:
        """Something of a known length begins. CancelledError is raised when it has to end early."""
        task = Task(text, total, unit, self.clock())
        with self._lock:
            self._tasks.append(task)

        def advance(done: float, total: float) -> None:
            with self._lock:
                if self._cancelled:
                    raise CancelledError
                if self._stage is not None and self._stage.unit == unit:
                    self._stage.done += done - task.done
                    self._stage.note = ""
                task.done, task.total = done, total
                if done >= total and task in self._tasks:
                    self._tasks.remove(task)
                    self._ended(task)

        return advance

    def steps(self, text: str, done: int, total: int) -> None:
        """`done` of `total` steps of the command are over, `text` happens now; 0: unknown."""
        with self._lock:
            if self._stage is None:
                self.stage("diagnosing", unit="steps")
            if self._stage is not None and total:
                self._stage.total, self._stage.done = total, done
            if self._stage is not None:
                self._stage.note = text

    def note(self, text: str) -> None:
        """Something to know at once, which stays."""

    def cancel(self) -> None:
        """End what runs in other threads, at its next report."""
        self._cancelled = True

    @contextmanager
    def paused(self) -> Iterator[None]:
        """Nothing is shown meanwhile: for a question to the user."""
        yield

    def titled(self, task: Task) -> str:
        """The title of a stage with its number among all, of a simulation as it is."""
        numbered = task is self._stage and self.stages
        return f"[{self._number}/{self.stages}] {task.text}" if numbered else task.text

    def _closed(self, well: bool) -> None:
        """The command is over. well: without an error."""

    def _begun(self, task: Task) -> None:
        """A stage begins."""

    def _ended(self, task: Task) -> None:
        """A stage or a simulation is done."""

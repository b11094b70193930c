"""Progress where nobody can draw: a line for each stage, and one every few seconds
in which something went on."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Self, TextIO

from flexhex.output.progress import Progress, Task

EVERY = 5.0
"""Time between two lines of one stage [s]."""


class Lines(Progress):
    """Writes to a stream that is no terminal. A thread calls `tick` while the command runs."""

    def __init__(self, stream: TextIO, clock: Callable[[], float] = time.monotonic) -> None:
        super().__init__(clock)
        self.stream = stream
        self._last = clock()
        self._said: tuple[Task, float, str] | None = None
        self._quiet = False
        self._over = threading.Event()
        self._ticker = threading.Thread(target=self._run, daemon=True)

    def __enter__(self) -> Self:
        self._ticker.start()
        return self

    def _closed(self, well: bool) -> None:
        self._over.set()

    def tick(self) -> None:
        """A line about what is under way, if the last one is old enough."""
        with self._lock:
            now = self.clock()
            task = self._stage or (self._tasks[0] if self._tasks else None)
            if task is None or self._quiet or now - self._last < EVERY:
                return
            if (task, task.done, task.note) != self._said:
                self._said = task, task.done, task.note
                self._write(f"{self.titled(task)}: {task.state(now)}", now)

    def note(self, text: str) -> None:
        """A line of its own."""
        with self._lock:
            self._write(text, self.clock())

    @contextmanager
    def paused(self) -> Iterator[None]:
        """No lines meanwhile."""
        self._quiet = True
        yield
        self._quiet = False

    def _begun(self, task: Task) -> None:
        self._write(self.titled(task), task.began)

    def _write(self, text: str, now: float) -> None:
        print(f"flexhex: {text}", file=self.stream, flush=True)
        self._last = now

    def _run(self) -> None:
        while not self._over.wait(0.5):
            self.tick()

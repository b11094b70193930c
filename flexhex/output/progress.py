"""Progress of the command line, on stderr."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from types import TracebackType
from typing import Any, Protocol

from rich.console import Console
from rich.progress import BarColumn, SpinnerColumn, TextColumn, TimeElapsedColumn
from rich.progress import Progress as Bars
from rich.table import Column


class Planned(Protocol):
    """A run whose progress is shown: its title, and how long it will last [s]."""

    @property
    def title(self) -> str:
        """What the run is."""

    @property
    def duration(self) -> float:
        """Simulated time [s]."""


class Progress(Protocol):
    """What a long computation reports while it goes on; the command line draws it."""

    def stage(self, text: str) -> None:
        """A new stage begins."""

    def case(self, case: Planned) -> Callable[[float, float], None]:
        """A case begins; what is returned is called with simulated and whole time [s]."""
        ...


class LiveProgress:
    """Bars with real-time factor for simulations, a line for each stage; a `Progress`."""

    def __init__(self) -> None:
        self._bars = Bars(
            SpinnerColumn(finished_text="✓"),
            TextColumn("{task.description}", table_column=Column(no_wrap=True, width=36)),
            BarColumn(bar_width=20),
            TextColumn("{task.fields[note]}"),
            TimeElapsedColumn(),
            console=Console(stderr=True),
        )
        self._stage: Any = None

    def __enter__(self) -> LiveProgress:
        self._bars.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if error is None:
            self._finish_stage()
        self._bars.stop()
        if kind is KeyboardInterrupt:
            print("flexhex: stopped", file=sys.stderr)

    def stage(self, text: str) -> None:
        """A new stage begins, the one before is done."""
        self._finish_stage()
        self._stage = self._bars.add_task(text, total=None, note="")

    def building(self, text: str) -> None:
        """Something is being built within the stage."""
        if self._stage is not None:
            self._bars.update(self._stage, note=text)

    def case(self, case: Planned) -> Callable[[float, float], None]:
        """A bar for one case."""
        return self.line(f"  {case.title}", case.duration)

    def line(self, text: str, duration: float) -> Callable[[float, float], None]:
        """A bar that is told the simulated time [s]."""
        task = self._bars.add_task(text, total=duration, note="")
        began = time.monotonic()

        def advance(t: float, end: float) -> None:
            speed = t / max(time.monotonic() - began, 1e-9)
            self._bars.update(
                task, completed=t, total=end, note=f"{t:5.1f} s  {speed:4.1f} × real time"
            )

        return advance

    def _finish_stage(self) -> None:
        if self._stage is not None:
            self._bars.update(self._stage, total=1, completed=1, note="")
            self._stage = None

"""The two runs of a comparison: what they are called, their colours, their tracking figures."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import cycle
from pathlib import Path

from flexhex.output.plots import COLOURS
from flexhex.recording import load_run
from flexhex.ssp.result import Result
from flexhex.tracking import Tracking, tracking

SPARE = ("#1f6fb2", "#d1731d")
"""Colours of runs that are no case of the report: those of adaptive and fixed."""


@dataclass(frozen=True)
class Run:
    """One run: its name (case or file), file, colour in plots, samples."""

    name: str
    file: str
    colour: str
    result: Result


@dataclass(frozen=True)
class Figure:
    """One figure of both runs, `ratio` second over first, NaN where there is none."""

    key: str
    title: str
    unit: str
    first: float
    second: float

    @property
    def ratio(self) -> float:
        """Second over first."""
        return self.second / self.first if self.first else math.nan


@dataclass(frozen=True)
class Figures:
    """Tracking of both runs over their common time, judged from begin to end [s]."""

    begin: float
    end: float
    rows: tuple[Figure, ...]


def load_runs(first: Path, second: Path) -> tuple[Run, Run]:
    """Both runs, results or recordings. LogError for a file that is neither."""
    paths = [first, second]
    a, b = named_runs(paths, [load_run(path) for path in paths])
    return a, b


def named_runs(paths: Sequence[Path], results: Sequence[Result]) -> list[Run]:
    """Runs with names that differ, and colours, which differ where there are two."""
    names = [_name(path, r) for path, r in zip(paths, results, strict=True)]
    if len(set(names)) < len(names):
        names = [str(path) for path in paths]
    if len(set(names)) < len(names):
        names = [f"{name} ({k})" for k, name in enumerate(names, start=1)]
    files, colours = [str(path) for path in paths], _colours([_case(r) for r in results])
    return [Run(*facts) for facts in zip(names, files, colours, results, strict=True)]


def _name(path: Path, result: Result) -> str:
    """Title of the case where the file tells it, else the name of the file."""
    return str(result.meta.get("title") or _case(result) or path.stem)


def _case(result: Result) -> str:
    return str(result.meta.get("case", ""))


def _colours(cases: list[str]) -> list[str]:
    """Colour of each run: that of its case in the report, never the same twice."""
    known = [COLOURS.get(case, "") for case in cases]
    if known[-1] in known[:-1]:
        known[-1] = ""
    free = [colour for colour in SPARE if colour not in known]
    spare = cycle(free or SPARE)
    return [colour or next(spare) for colour in known]


def figures(first: Run, second: Run) -> Figures | None:
    """Tracking figures of the time that both cover; None when a run has no `feedback.e`."""
    end = min(first.result.duration, second.result.duration)
    a, b = tracking(first.result, end), tracking(second.result, end)
    if a is None or b is None:
        return None
    rows = [
        Figure("e_rms_urad", "tracking error e, RMS", "µrad", a.e, b.e),
        Figure("e_max_urad", "tracking error |e|, largest", "µrad", a.e_max, b.e_max),
    ]
    if math.isfinite(a.tau_fb) and math.isfinite(b.tau_fb):
        title = "feedback torque τ_FB, RMS"
        rows.append(Figure("tau_fb_rms_Nm", title, "N m", a.tau_fb, b.tau_fb))
    return Figures(*_judged(a, b), tuple(rows))


def _judged(a: Tracking, b: Tracking) -> tuple[float, float]:
    return min(a.begin, b.begin), max(a.end, b.end)

"""Runs of cases: variants of a case of Table I, simulated side by side, their samples."""

from __future__ import annotations

import dataclasses
import hashlib
import math
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, as_completed
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from flexhex.output.progress import Progress
from flexhex.simulation.builder import Builder
from flexhex.simulation.cases import SETTLE, Case
from flexhex.ssp.executor import run
from flexhex.ssp.results import Result, provenance, save

C = TypeVar("C")
T = TypeVar("T")
Array = NDArray[np.float64]
Starts = Mapping[str, Mapping[str, float | Array]]
WORKERS = 2
"""Runs at the same time; the executor leaves Python alone, so threads are enough."""


def variant(base: Case, name: str, title: str, duration: float, starts: Starts) -> Case:
    """A case of another name and whole duration [s]; `starts` go over those of the base."""
    named = [*base.starts, *(k for k in starts if k not in base.starts)]
    merged = {k: {**base.starts.get(k, {}), **starts.get(k, {})} for k in named}
    return dataclasses.replace(base, name=name, title=title, duration=duration, starts=merged)


def side_by_side(cases: Sequence[C], one: Callable[[C], T], progress: Progress) -> list[T]:
    """`one` of every case, in their order, `WORKERS` at a time.

    The first error, or Ctrl-C, ends them all: those under way at their next report of progress.
    """
    with ThreadPoolExecutor(WORKERS) as pool:
        waiting = [pool.submit(one, case) for case in cases]
        try:
            return [future.result() for future in _as_they_end(waiting)]
        except BaseException:
            progress.cancel()
            for future in waiting:
                future.cancel()
            raise


def _as_they_end(waiting: Sequence[Future[T]]) -> Sequence[Future[T]]:
    """The same, when all are done; the first error as soon as it is there."""
    for future in as_completed(waiting):
        future.result()
    return waiting


def record(
    builder: Builder,
    cases: Sequence[Case],
    signals: Sequence[str],
    command: str,
    progress: Progress,
) -> list[Result]:
    """Build and run cases side by side, log `signals` alone, save `out/runs/<case>.h5`.

    Memory is why not all signals are logged: three passes of 50 s are 600 000 samples.
    The first error ends them all.
    """

    def one(case: Case) -> Result:
        return recorded(builder, case, signals, command, progress, timing=False)[0]

    return side_by_side(cases, one, progress)


def recorded(
    builder: Builder,
    case: Case,
    signals: Sequence[str],
    command: str,
    progress: Progress,
    saved: Sequence[str] | None = None,
    timing: bool = True,
) -> tuple[Result, dict[str, str | int | float]]:
    """Build the variant of one case, run it, save `out/runs/<case>.h5`.

    saved: signals that the file holds, default all logged ones; timing: measure the time in each
    FMU. Returns result and provenance.
    """
    description = builder.case(case)
    shown = progress.case(case)
    result = run(description, case.duration, signals=signals, progress=shown, timing=timing)
    named = {"case": case.name, "title": case.title, "machine": builder.machine.name}
    named["sha256 machine file"] = hashlib.sha256(builder.machine_file.read_bytes()).hexdigest()
    versions = provenance(command=command, **named)
    meta = {**versions, **result.meta}
    save(result if saved is None else reduced(result, saved), run_file(builder, case), meta)
    return result, meta


def reduced(result: Result, names: Sequence[str]) -> Result:
    """The result with some of its signals only, without the groups that then are empty."""
    groups = {}
    for rate, group in result.groups.items():
        signals = {name: values for name, values in group.signals.items() if name in names}
        if signals:
            groups[rate] = dataclasses.replace(group, signals=signals)
    return dataclasses.replace(result, groups=groups)


def run_file(builder: Builder, case: Case) -> Path:
    """Where `recorded` saves a case."""
    return builder.out / "runs" / f"{case.name}.h5"


def samples(result: Result, signal: str, after: float = SETTLE) -> tuple[Array, Array, float]:
    """Time since `after` [s], samples from then on, sample time [s] of a signal."""
    group = result.group(signal)
    first = math.ceil(after / group.Ts - 1e-9)
    return group.time[first:] - after, group.signals[signal][first:], group.Ts


def whole(time: float, base: float) -> float:
    """The multiple of the base step that is nearest to a time [s]."""
    return round(time / base) * base

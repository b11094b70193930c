"""What the experiments share: variants of a case of Table I, runs side by side, samples."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from flexhex.cases import SETTLE, Case
from ssp.executor import run
from ssp.results import Result, provenance, save

if TYPE_CHECKING:  # flexhex.run may import the experiments
    from flexhex.build import Builder
    from flexhex.run import Progress

Array = NDArray[np.float64]
Starts = Mapping[str, Mapping[str, float | Array]]
WORKERS = 2
"""Runs at the same time; the executor leaves Python alone, so threads are enough."""


def variant(base: Case, name: str, title: str, duration: float, starts: Starts) -> Case:
    """A case of another name and whole duration [s]; `starts` go over those of the base."""
    named = [*base.starts, *(k for k in starts if k not in base.starts)]
    merged = {k: {**base.starts.get(k, {}), **starts.get(k, {})} for k in named}
    return dataclasses.replace(base, name=name, title=title, duration=duration, starts=merged)


def record(
    builder: Builder,
    cases: Sequence[Case],
    signals: Sequence[str],
    command: str,
    progress: Progress,
) -> tuple[Result, ...]:
    """Build and run cases side by side, log `signals` alone, save `out/runs/<case>.h5`.

    Memory is why not all signals are logged: three passes of 50 s are 600 000 samples.
    The first error ends them all.
    """

    def one(case: Case) -> Result:
        description = builder.case(case)
        result = run(description, case.duration, signals=signals, progress=progress.case(case))
        made = provenance(command=command, case=case.name, machine=builder.machine.name)
        save(result, builder.out / "runs" / f"{case.name}.h5", {**made, **result.meta})
        return result

    with ThreadPoolExecutor(WORKERS) as pool:
        waiting = [pool.submit(one, case) for case in cases]
        try:
            return tuple(future.result() for future in waiting)
        except BaseException:
            for future in waiting:
                future.cancel()
            raise


def samples(result: Result, signal: str, after: float = SETTLE) -> tuple[Array, Array, float]:
    """Time since `after` [s], samples from then on, sample time [s] of a signal."""
    group = result.group(signal)
    first = math.ceil(after / group.Ts - 1e-9)
    return group.time[first:] - after, group.signals[signal][first:], group.Ts


def whole(time: float, base: float) -> float:
    """The multiple of the base step that is nearest to a time [s]."""
    return round(time / base) * base

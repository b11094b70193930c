"""`flexhex run`: build, fit p-hat, simulate the paper's cases, gather what the report shows."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from diagnosis.identify import Fit, fit
from diagnosis.logs import read_log
from flexhex.build import Builder
from flexhex.cases import SETTLE, Case, extra_cases, fit_case, table_cases
from flexhex.metrics import Figures, figures
from ssp.executor import run
from ssp.results import Result, save

Array = NDArray[np.float64]
PARAMETER_SIGNALS = ("K.p", "K.p_std", "K.innovation")
WORKERS = 2
"""Runs at the same time; the executor leaves Python alone, so threads are enough."""


@dataclass(frozen=True)
class Outcome:
    """One finished case: figures judged after the settling time, result file, speed."""

    case: Case
    figures: Figures
    path: Path
    result: Result
    wall: float

    @property
    def real_time_factor(self) -> float:
        """Simulated seconds in a second of computing."""
        return self.case.duration / self.wall


@dataclass(frozen=True)
class Study:
    """All that one `flexhex run` found."""

    builder: Builder
    fit: Fit
    fit_outcome: Outcome
    table: tuple[Outcome, ...]
    extra: tuple[Outcome, ...]
    command: str
    wall: float


class Progress:
    """What a run reports while it goes on; the command line draws it."""

    def stage(self, text: str) -> None:
        """A new stage begins."""

    def case(self, case: Case) -> Callable[[float], None]:
        """A case begins; the result is called with the simulated time [s]."""
        return lambda t: None


def study(builder: Builder, command: str, quick: bool, progress: Progress) -> Study:
    """The whole of `flexhex run`; quick: short trajectories and the table's cases alone."""
    began, machine = time.monotonic(), builder.machine
    seconds = 8.0 if quick else machine.reference.duration
    progress.stage("building the FMUs")
    builder.systems()
    progress.stage("simulating the data that p is fitted to")
    measured = simulate(builder, fit_case(machine, 20.0 if quick else seconds), command, progress)
    progress.stage("fitting the parameters")
    estimate = fit(machine, [read_log(measured.path)], settle=SETTLE)
    progress.stage("simulating the cases")
    cases = table_cases(machine, estimate.p, seconds)
    extra = () if quick else extra_cases(machine, estimate.p, seconds)
    outcomes = simulate_all(builder, (*cases, *extra), command, progress)
    table, rest = outcomes[: len(cases)], outcomes[len(cases) :]
    wall = time.monotonic() - began
    return Study(builder, estimate, measured, table, rest, command, wall)


def simulate_all(
    builder: Builder, cases: Sequence[Case], command: str, progress: Progress
) -> tuple[Outcome, ...]:
    """Run cases side by side; in their order. The first error ends them all."""
    with ThreadPoolExecutor(WORKERS) as pool:
        waiting = [pool.submit(simulate, builder, case, command, progress) for case in cases]
        try:
            return tuple(future.result() for future in waiting)
        except BaseException:
            for future in waiting:
                future.cancel()
            raise


def simulate(builder: Builder, case: Case, command: str, progress: Progress) -> Outcome:
    """Build the variant of one case, run it, save `out/runs/<case>.h5`."""
    description = builder.case(case)
    advance = progress.case(case)
    began = time.monotonic()
    result = run(description, case.duration, progress=advance, also=PARAMETER_SIGNALS)
    wall = time.monotonic() - began
    path = builder.out / "runs" / f"{case.name}.h5"
    save(result, path, {"command": command, "case": case.name, "machine": builder.machine.name})
    return Outcome(case, _figures(builder, result), path, result, wall)


def _figures(builder: Builder, result: Result) -> Figures:
    group = result.group_of("plant.theta")
    judged = group.time > SETTLE
    signals = group.signals
    return figures(
        builder.machine,
        signals["plant.theta"][judged],
        signals["feedback.e"][judged],
        signals["feedback.tau_fb"][judged],
    )

"""`flexhex run`: build, fit p-hat, simulate the paper's cases and the experiments."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.estimation.identify import TOLERANCE, Fit, fit
from flexhex.diagnosis.logs import read_log
from flexhex.experiments import EXPERIMENTS, experiment
from flexhex.experiments.repeatability import evaluate
from flexhex.fmugen.blocks import BLOCKS
from flexhex.fmus.common.machine.machine import Machine
from flexhex.output.progress import Progress
from flexhex.run.actuators import actuators_builder
from flexhex.run.outcome import Outcome, PaperRun, Rows
from flexhex.simulation.builder import Builder
from flexhex.simulation.cases import SETTLE, Case, extra_cases, fit_case, table_cases, whole_moves
from flexhex.simulation.metrics import Figures, figures
from flexhex.simulation.passes import repeatability_figures, repeated_case
from flexhex.simulation.published import published
from flexhex.simulation.runs import recorded, run_file, side_by_side
from flexhex.ssp.results import Result
from flexhex.ssp.signals import DEFAULT

Array = NDArray[np.float64]
TABLE = "table"
SHORT, SHORT_FIT = 8.0, 20.0
"""Length of the trajectories of a quick run [s]: of the cases, and of the fit's, which is longer
since a fit to 8 s determines too few parameters."""
FAULTS = tuple(f"{name}.fault" for name in ("feedback", "plant", "N_F", "N_E", "W", "F", "K"))
JUDGED = ("plant.theta", "feedback.e", "feedback.tau_fb")
"""Signals that the figures of a case are computed from."""
MEASURED = ("plant.theta", "plant.tau_meas", "reference.r")
"""Signals of a measured log: what identify and diagnose read."""
PLOTTED = {"adaptive": ("feedback.tau", "F.tau_ff", "K.p", "K.p_std")}
"""Further signals that the report plots, by case."""
SAVED = {
    "fit": (*MEASURED, *FAULTS),
    "repeatability": FAULTS,
    "feedback": (*JUDGED, *MEASURED, *FAULTS),
    "fixed": (*JUDGED, *MEASURED, *FAULTS),
    "adaptive": (*JUDGED, *MEASURED, "K.p", "K.p_std", *FAULTS),
}
"""Signals that the files of these cases hold: for identify, diagnose and compare."""
SAVED_ACTUATORS = {
    "fit": ("plant.theta", "plant.tau_meas", *FAULTS),
    **dict.fromkeys(("feedback", "fixed", "adaptive", "repeatability"), FAULTS),
}
"""The same of the actuators alone."""
SAVED_ELSE = ("feedback.e", *FAULTS)
"""The same for the variants: 50 s of one joint vector take 7 MB, of all signals 80 MB."""


def paper_run(
    builder: Builder,
    command: str,
    quick: bool,
    progress: Progress,
    only: str | None = None,
    keep_all: bool = False,
) -> PaperRun:
    """The whole of `flexhex run`; quick: short trajectories and Table I alone.

    only: `table` or the name of one experiment. keep_all: save every signal of every case.
    UsageError for another name, MachineError for a machine file that cannot be built.
    """
    began, machine = time.monotonic(), builder.machine
    names = chosen(only, quick, builder.has_truth)
    with_table = TABLE in names
    builder.check()
    alone = actuators_builder(builder) if with_table else None
    seconds = whole_moves(machine, SHORT) if quick else machine.reference.duration
    progress.stages = stage_count(names, alone is not None)
    runs = Runs(builder, command, progress, None if keep_all else SAVED)
    estimate, measured = runs.fitted(SHORT_FIT if quick else seconds)
    table = Rows()
    extra: tuple[Outcome, ...] = ()
    if with_table:
        extra_rows = () if quick else variants(builder, machine, estimate, seconds)
        table, extra = runs.table(estimate, seconds, extra_rows)
    actuators = actuator_rows(runs, alone, seconds) if alone else Rows()
    results: dict[str, Any] = {}
    for name in names[with_table:]:
        if name == "repeatability" and table:
            # both of its runs are rows of the table
            both = [table.of(row).result for row in ("repeatability", "adaptive")]
            results[name] = evaluate(machine, both, table.published)
            continue
        progress.stage(experiment(name).title.lower())
        results[name] = experiment(name).run(builder, estimate, progress, command, quick)
    wall = time.monotonic() - began
    return PaperRun(builder, estimate, measured, table, extra, actuators, results, command, wall)


def chosen(only: str | None, quick: bool, with_truth: bool) -> list[str]:
    """What a run does, `table` first; with_truth: the machine differs from its model."""
    if only is None:
        every = [TABLE, *(e.name for e in EXPERIMENTS.values() if with_truth or not e.with_truth)]
        return every[:1] if quick else every
    if only != TABLE:
        experiment(only)
    return [only]


def stage_count(names: Sequence[str], with_actuators: bool) -> int:
    """Stages of a run, as its progress numbers them; `missing` has two of its own."""
    fitted, report = 3, 1
    without = TABLE in names and "repeatability" in names
    own = 2 * names.count("missing")
    return fitted + with_actuators * (fitted + 1) + len(names) - without + own + report


def all_rows(machine: Machine, estimate: Fit, seconds: float) -> tuple[Case, ...]:
    """The cases of Table I, its last row included."""
    rows = table_cases(machine, estimate.p, seconds, estimate.std)
    return (*rows, repeated_case(machine, estimate.p, seconds))


def variants(builder: Builder, machine: Machine, estimate: Fit, seconds: float) -> tuple[Case, ...]:
    """Cases beyond Table I. Where the machine is its model, those on the model are rows already."""
    every = extra_cases(machine, estimate.p, seconds, estimate.std)
    return every if builder.has_truth else every[:1]


def actuator_rows(runs: Runs, alone: Builder, seconds: float) -> Rows:
    """The right half of Table I, with a fit of its own."""
    own = Runs(alone, runs.command, runs.progress, runs.saved and SAVED_ACTUATORS)
    estimate, _ = own.fitted(max(seconds, SHORT_FIT))
    return own.table(estimate, seconds, ())[0]


class Runs:
    """Simulations of one machine under one command. saved: signals in the file of a case, by its
    name; None: all."""

    def __init__(
        self,
        builder: Builder,
        command: str,
        progress: Progress,
        saved: Mapping[str, Sequence[str]] | None,
    ) -> None:
        self.builder, self.command, self.progress = builder, command, progress
        self.saved = saved

    def fitted(self, seconds: float) -> tuple[Fit, Outcome]:
        """FMUs built, another trajectory simulated on the cold machine, p fitted to its log."""
        machine, name = self.builder.machine, self.builder.machine.name
        self.progress.stage(f"building the FMUs of {name}", len(BLOCKS), "FMUs")
        self.builder.systems()
        case = fit_case(machine, whole_moves(machine, seconds))
        self.progress.stage("simulating the data for the fit", case.duration)
        measured = self.simulate(case)
        self.progress.stage(f"fitting the parameters of {name}")
        log = read_log(run_file(self.builder, case))
        return fit(machine, [log], settle=SETTLE, tolerance=TOLERANCE), measured

    def table(
        self, estimate: Fit, seconds: float, extra: Sequence[Case]
    ) -> tuple[Rows, tuple[Outcome, ...]]:
        """The rows of Table I, and further cases simulated with them."""
        rows = all_rows(self.builder.machine, estimate, seconds)
        whole = sum(case.duration for case in (*rows, *extra))
        self.progress.stage(f"simulating the cases of {self.builder.machine.name}", whole)
        outcomes = side_by_side((*rows, *extra), self.simulate, self.progress)
        first = tuple(outcomes[: len(rows)])
        return Rows(first, published(self.builder.machine_file)), tuple(outcomes[len(rows) :])

    def simulate(self, case: Case) -> Outcome:
        """Build the variant of one case, run it, save `out/runs/<case>.h5`."""
        case = self.builder.simulated(case)
        signals: Sequence[str] = (DEFAULT, "K.p", "K.p_std")
        saved = None
        if self.saved is not None:
            saved = self.saved.get(case.name, SAVED_ELSE)
            # in an order of its own: files of the same run are the same bytes
            signals = sorted({*JUDGED, *saved, *PLOTTED.get(case.name, ())})
        result, provenance = recorded(
            self.builder, case, signals, self.command, self.progress, saved
        )
        return Outcome(case, judged(self.builder.machine, case, result), result, provenance)


def judged(machine: Machine, case: Case, result: Result) -> Figures:
    """Figures of a case after the settling time."""
    if case.name == "repeatability":
        return repeatability_figures(machine, result)
    group = result.group("plant.theta")
    after = group.time > SETTLE
    return figures(machine, *(group.signals[name][after] for name in JUDGED))

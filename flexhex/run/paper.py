"""`flexhex run`: build, fit p-hat, simulate the paper's cases, gather what the report shows."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.identify import TOLERANCE, Fit, fit
from flexhex.diagnosis.logs import read_log
from flexhex.experiments import EXPERIMENTS, experiment
from flexhex.experiments.repeatability import evaluate
from flexhex.fmus.common.errors import MachineError
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.machine_file import read_toml, truth_file
from flexhex.output.progress import Progress
from flexhex.simulation.builder import Builder
from flexhex.simulation.cases import SETTLE, Case, extra_cases, fit_case, table_cases, whole_moves
from flexhex.simulation.faults import Fault, faults
from flexhex.simulation.metrics import Figures, figures
from flexhex.simulation.passes import repeatability_figures, repeatable_share, repeated_case
from flexhex.simulation.runs import recorded, side_by_side
from flexhex.ssp.results import Result
from flexhex.ssp.signals import DEFAULT

Array = NDArray[np.float64]
TABLE = "table"
SIGNALS = (DEFAULT, "K.p", "K.p_std")
FAULTS = tuple(f"{name}.fault" for name in ("feedback", "plant", "N_F", "N_E", "W", "F", "K"))
REPEATED = ("plant.theta", "feedback.e", "feedback.tau_fb", *FAULTS)
"""What the three passes log: with all signals they would be a third of all results."""


@dataclass(frozen=True)
class Outcome:
    """One finished case: figures judged after the settling time, result file, what made it."""

    case: Case
    figures: Figures
    path: Path
    result: Result
    made: Mapping[str, str | int | float]

    @property
    def real_time_factor(self) -> float:
        """Simulated seconds in a second of computing."""
        return self.result.duration / self.result.wall


@dataclass(frozen=True)
class PaperRun:
    """All that one `flexhex run` found."""

    builder: Builder
    fit: Fit
    fit_outcome: Outcome
    table: tuple[Outcome, ...]
    extra: tuple[Outcome, ...]
    actuators: tuple[Outcome, ...]
    experiments: Mapping[str, Any]
    command: str
    wall: float

    @property
    def compared(self) -> tuple[Outcome, ...]:
        """The three cases of one pass: feedback only, fixed, adaptive."""
        return tuple(o for o in self.table if o.case.name != "repeatability")

    @property
    def adaptive(self) -> Outcome:
        """The adaptive row."""
        return row(self.table, "adaptive")

    @property
    def share(self) -> float:
        """Share of the adaptive run's feedback torque that repeats."""
        return repeatable_share(row(self.table, "repeatability").figures, self.adaptive.figures)

    @property
    def faults(self) -> list[Fault]:
        """The faults of all rows of the report's tables."""
        found = []
        for outcome in (self.fit_outcome, *self.table, *self.extra):
            found += faults(outcome.case.title, outcome.result)
        for outcome in self.actuators:
            found += faults(f"actuators alone, {outcome.case.title}", outcome.result)
        return found


def row(outcomes: Sequence[Outcome], name: str) -> Outcome:
    """The outcome of the case of that name."""
    return next(o for o in outcomes if o.case.name == name)


def paper_run(
    builder: Builder, command: str, quick: bool, progress: Progress, only: str | None = None
) -> PaperRun:
    """The whole of `flexhex run`; quick: short trajectories and Table I alone.

    only: `table` or the name of one experiment. UsageError for another name.
    """
    began, machine = time.monotonic(), builder.machine
    wanted = chosen(only, quick)
    check_truth(builder)
    builder.check()
    if TABLE in wanted:
        check_actuators(builder)
    seconds = whole_moves(machine, 8.0) if quick else machine.reference.duration
    estimate, measured = fitted(builder, 20.0 if quick else seconds, command, progress)
    outcomes: tuple[Outcome, ...] = ()
    alone: tuple[Outcome, ...] = ()
    cases = all_rows(machine, estimate, seconds)
    if TABLE in wanted:
        progress.stage("simulating the cases")
        extra = () if quick else extra_cases(machine, estimate.p, seconds, estimate.std)
        outcomes = simulate_all(builder, (*cases, *extra), command, progress)
        alone = actuators_alone(builder, seconds, command, progress)
    found: dict[str, Any] = {}
    if "repeatability" in wanted and outcomes:
        # both of its runs are rows of the table
        both = (row(outcomes, name).result for name in ("repeatability", "adaptive"))
        found["repeatability"] = evaluate(machine, *both)
    for name in wanted[wanted.count(TABLE) :]:
        if name in found:
            continue
        chosen_one = experiment(name)
        progress.stage(chosen_one.title.lower())
        found[name] = chosen_one.run(builder, estimate, progress, command, quick)
    table, rest = outcomes[: len(cases)], outcomes[len(cases) :]
    wall = time.monotonic() - began
    return PaperRun(builder, estimate, measured, table, rest, alone, found, command, wall)


def chosen(only: str | None, quick: bool) -> list[str]:
    """What a run does, `table` first."""
    if only is None:
        return [TABLE] if quick else [TABLE, *(e.name for e in EXPERIMENTS.values() if not e.asked)]
    if only != TABLE:
        experiment(only)
    return [only]


def all_rows(machine: Machine, found: Fit, seconds: float) -> tuple[Case, ...]:
    """The cases of Table I, its last row included."""
    rows = table_cases(machine, found.p, seconds, found.std)
    return (*rows, repeated_case(machine, found.p, seconds))


def check_truth(builder: Builder) -> None:
    """MachineError when there is no machine that the cases could run on."""
    truth = truth_file(builder.machine_file)
    if not truth.exists():
        raise MachineError(
            f"{truth}: no such file: the cases run on a machine that differs from its model, and"
            " this file says how; copy machines/tflex-truth.toml, or use `flexhex simulate`"
        )


def actuators_file(machine_file: Path) -> Path:
    """Where the machine file of the actuators alone would stand: `tflex-actuators.toml`."""
    return machine_file.with_name(f"{machine_file.stem}-actuators.toml")


def check_actuators(builder: Builder) -> None:
    """MachineError when `<machine>-actuators.toml` is there and is not that machine's own."""
    path = actuators_file(builder.machine_file)
    if not path.exists():
        return
    base = read_toml(path).get("extends")
    if base is None or (path.parent / str(base)).resolve() != builder.machine_file.resolve():
        raise MachineError(
            f"{path}: extends: wants {builder.machine_file.name!r}, is {base!r}: its rows stand"
            " beside that machine's, so extend it, or give this file another name"
        )
    alone = Builder(path, builder.out)
    if alone.machine.has_platform:
        raise MachineError(f"{path}: has a platform: add `without_platform = true`")
    alone.check()


def fitted(
    builder: Builder, seconds: float, command: str, progress: Progress
) -> tuple[Fit, Outcome]:
    """FMUs built, another trajectory simulated on the cold machine, p fitted to its log."""
    progress.stage(f"building the FMUs of {builder.machine.name}")
    builder.systems()
    progress.stage("simulating the data that p is fitted to")
    measured = simulate(
        builder, fit_case(builder.machine, whole_moves(builder.machine, seconds)), command, progress
    )
    progress.stage("fitting the parameters")
    log = read_log(measured.path)
    return fit(builder.machine, [log], settle=SETTLE, tolerance=TOLERANCE), measured


def actuators_alone(
    builder: Builder, seconds: float, command: str, progress: Progress
) -> tuple[Outcome, ...]:
    """The right half of Table I, when `<machine>-actuators.toml` stands beside the machine."""
    path = actuators_file(builder.machine_file)
    if not path.exists():
        return ()
    alone = Builder(path, builder.out / "actuators", builder.say)
    estimate, _ = fitted(alone, max(seconds, 20.0), command, progress)
    progress.stage("simulating the actuators alone")
    return simulate_all(alone, all_rows(alone.machine, estimate, seconds), command, progress)


def simulate_all(
    builder: Builder, cases: Sequence[Case], command: str, progress: Progress
) -> tuple[Outcome, ...]:
    """Run cases side by side; in their order. The first error ends them all."""
    return tuple(side_by_side(cases, lambda case: simulate(builder, case, command, progress)))


def simulate(builder: Builder, case: Case, command: str, progress: Progress) -> Outcome:
    """Build the variant of one case, run it, save `out/runs/<case>.h5`."""
    wanted = REPEATED if case.name == "repeatability" else SIGNALS
    result, path, made = recorded(builder, case, wanted, command, progress)
    return Outcome(case, _figures(builder, case, result), path, result, made)


def _figures(builder: Builder, case: Case, result: Result) -> Figures:
    if case.name == "repeatability":
        return repeatability_figures(builder.machine, result)
    group = result.group("plant.theta")
    judged = group.time > SETTLE
    signals = group.signals
    return figures(
        builder.machine,
        signals["plant.theta"][judged],
        signals["feedback.e"][judged],
        signals["feedback.tau_fb"][judged],
    )

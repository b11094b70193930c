"""What the command line shows: progress on stderr, results on stdout."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from types import TracebackType
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn
from rich.table import Column, Table

from flexhex.cases import Case
from flexhex.experiments import experiment
from flexhex.faults import Fault, faults, study_faults
from flexhex.fit_view import warn_of
from flexhex.metrics import COLUMNS, PAPER, PAPER_ACTUATORS
from flexhex.repeatability import PAPER_SHARE
from flexhex.run import Outcome, Study
from ssp.results import Result

MOST_ROWS = 12
"""Rows of an experiment that the terminal shows."""


class LiveProgress:
    """Bars with real-time factor for simulations, a line for each stage; a `run.Progress`."""

    def __init__(self) -> None:
        self._bars = Progress(
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

    def case(self, case: Case) -> Callable[[float, float], None]:
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


def print_study(study: Study, report: Path) -> None:
    """Table I beside the paper's figures, what stands beside it, time per FMU, the report."""
    out = Console()
    if study.table:
        _print_table(out, study)
    for name, result in study.experiments.items():
        out.print(_rows(name, result))
    _print_faults(out, study_faults(study))
    out.print(f"results  {study.builder.out / 'runs'}", highlight=False)
    out.print(f"report   {report}  (took {study.wall:.0f} s)", highlight=False)


def _print_table(out: Console, study: Study) -> None:
    out.print()
    out.print(_table(study.table))
    if study.actuators:
        out.print(_actuators(study.actuators))
    if study.extra:
        out.print(_beside(study.extra))
    out.print(_speed(study.adaptive.result, f"Time in each FMU, {study.adaptive.case.title}"))
    out.print(
        f"{study.share:.1%} of the adaptive run's feedback torque repeats"
        f" (paper: {PAPER_SHARE:.1%}): a better model could remove it"
    )
    warn_of(out, study.fit)
    loose = len(study.fit.undetermined)
    out.print(
        f"p fitted to {study.fit.samples} torque values of another trajectory;"
        f" {loose} of {len(study.fit.p)} not determined by themselves"
    )


def _rows(name: str, result: Any) -> Table | str:
    """The rows of an experiment as a table, where the terminal has room for them."""
    chosen = experiment(name)
    rows = chosen.rows(result)
    if len(rows) > MOST_ROWS:
        return f"{chosen.title}: {len(rows)} rows in the report"
    table = Table(title=chosen.title, box=SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    for key, value in rows[0].items():
        table.add_column(key, justify="left" if isinstance(value, str) else "right")
    for row in rows:
        table.add_row(*(f"{v:.4g}" if isinstance(v, float) else str(v) for v in row.values()))
    return table


def _table(outcomes: Sequence[Outcome]) -> Table:
    title = "RMS tracking error and feedback torque"
    table = Table(title=title, box=SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    table.add_column("", no_wrap=True)
    for name, unit in COLUMNS:
        table.add_column(f"{name}\n[dim]{unit}[/]", justify="right", no_wrap=True)
    for outcome in outcomes:
        ours = [_number(value, k) for k, value in enumerate(outcome.figures.row())]
        paper = [_number(value, k) for k, value in enumerate(PAPER[outcome.case.name])]
        table.add_row(outcome.case.title, *ours)
        table.add_row("  paper", *paper, style="dim", end_section=True)
    return table


def _actuators(outcomes: Sequence[Outcome]) -> Table:
    title = "Actuators with their upper arms alone"
    table = Table(title=title, box=SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    table.add_column("", no_wrap=True)
    for name, unit in COLUMNS[:2]:
        table.add_column(f"{name}\n[dim]{unit}[/]", justify="right", no_wrap=True)
        table.add_column("[dim]paper[/]", justify="right", no_wrap=True, style="dim")
    for outcome in outcomes:
        e, tau_fb = PAPER_ACTUATORS[outcome.case.name]
        ours = _number(outcome.figures.e, 0), _number(outcome.figures.tau_fb, 1)
        table.add_row(outcome.case.title, ours[0], _number(e, 0), ours[1], _number(tau_fb, 1))
    return table


def _number(value: float, column: int) -> str:
    """Three digits and more where they fit into six places."""
    if column == 1:
        return f"{value:.4f}"
    return f"{value:.0f}" if value >= 1000 else f"{value:.1f}"


def _beside(outcomes: Sequence[Outcome]) -> Table:
    table = Table(title="Beside the table", box=SIMPLE_HEAD)
    for name in ("case", "plant"):
        table.add_column(name)
    for name in ("e\n[dim]µrad[/]", "τ_FB\n[dim]N m[/]"):
        table.add_column(name, justify="right")
    for o in outcomes:
        cells = (f"{o.figures.e:.2f}", f"{o.figures.tau_fb:.5f}")
        table.add_row(o.case.title, f"{o.case.plant}.fmu", *cells)
    return table


def _speed(result: Result, title: str) -> Table:
    table = Table(title=title, box=SIMPLE_HEAD)
    table.add_column("FMU")
    for name in ("steps", "µs a step", "ms per simulated s"):
        table.add_column(name, justify="right")
    for name, spent in result.times.items():
        mean = spent.seconds / max(spent.steps, 1) * 1e6
        share = spent.seconds / result.duration * 1e3
        table.add_row(name, str(spent.steps), f"{mean:.2f}", f"{share:.2f}")
    return table


def print_speed(result: Result) -> None:
    """Time spent in each FMU, and the faults that were reported."""
    out = Console()
    out.print(_speed(result, "Time in each FMU"))
    _print_faults(out, faults("the run", result))


def _print_faults(out: Console, listed: Sequence[Fault]) -> None:
    """One line for each component that reported a fault: which, how often, since when."""
    for fault in listed:
        out.print(f"[red]fault[/] in {fault}; see fmus/*/README.md", highlight=False)


def study_json(study: Study, report: Path) -> str:
    """Figures of all cases as JSON: e [urad], tau_fb [N m], positions [um], angles [urad]."""
    cases = {
        o.case.name: vars(o.figures) | {"real_time_factor": o.real_time_factor}
        for o in (*study.table, *study.extra)
    }
    alone = {o.case.name: {"e": o.figures.e, "tau_fb": o.figures.tau_fb} for o in study.actuators}
    found = {
        "cases": cases,
        "actuators": alone,
        "faults": [asdict(fault) for fault in study_faults(study)],
        "repeatable_share": study.share if study.table else None,
        "undetermined": list(study.fit.undetermined),
        "fit_warnings": list(study.fit.warnings),
        "paper": PAPER,
        "paper_actuators": PAPER_ACTUATORS,
        "report": str(report),
    }
    return json.dumps(found, indent=2)


def print_findings(findings: Mapping[Path, Sequence[str]]) -> None:
    """One line for each file that is well, the complaints of the others."""
    for path, complaints in findings.items():
        for text in complaints:
            print(text)
        if not complaints:
            print(f"{path}: ok")

"""What `flexhex run` shows in the terminal, or the same as JSON."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from flexhex.experiments import experiment
from flexhex.identify.view import warn_of
from flexhex.run.paper import Outcome, PaperRun
from flexhex.simulate.view import print_faults, speed_table
from flexhex.simulation.metrics import COLUMNS, PAPER, PAPER_ACTUATORS
from flexhex.simulation.passes import PAPER_SHARE

MOST_ROWS = 12
"""Rows of an experiment that the terminal shows."""


def print_run(run: PaperRun, report: Path) -> None:
    """Table I beside the paper's figures, what stands beside it, time per FMU, the report."""
    out = Console()
    if run.table:
        _print_table(out, run)
    for name, result in run.experiments.items():
        out.print(_rows(name, result))
    print_faults(out, run.faults)
    out.print(f"results  {run.builder.out / 'runs'}", highlight=False)
    out.print(f"report   {report}  (took {run.wall:.0f} s)", highlight=False)


def _print_table(out: Console, run: PaperRun) -> None:
    out.print()
    out.print(_table(run.table))
    if run.actuators:
        out.print(_actuators(run.actuators))
    if run.extra:
        out.print(_beside(run.extra))
    out.print(speed_table(run.adaptive.result, f"Time in each FMU, {run.adaptive.case.title}"))
    out.print(
        f"{run.share:.1%} of the adaptive run's feedback torque repeats"
        f" (paper: {PAPER_SHARE:.1%}): a better model could remove it"
    )
    warn_of(out, run.fit)
    loose = len(run.fit.undetermined)
    out.print(
        f"p fitted to {run.fit.samples} torque values of another trajectory;"
        f" {loose} of {len(run.fit.p)} not determined by themselves"
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


def run_json(run: PaperRun, report: Path) -> str:
    """Figures of all cases as JSON: e [urad], tau_fb [N m], positions [um], angles [urad]."""
    cases = {
        o.case.name: vars(o.figures) | {"real_time_factor": o.real_time_factor}
        for o in (*run.table, *run.extra)
    }
    alone = {o.case.name: {"e": o.figures.e, "tau_fb": o.figures.tau_fb} for o in run.actuators}
    found = {
        "cases": cases,
        "actuators": alone,
        "faults": [asdict(fault) for fault in run.faults],
        "repeatable_share": run.share if run.table else None,
        "undetermined": list(run.fit.undetermined),
        "fit_warnings": list(run.fit.warnings),
        "experiments": _experiments(run),
        "paper": PAPER,
        "paper_actuators": PAPER_ACTUATORS,
        "report": str(report),
    }
    return json.dumps(found, indent=2)


def _experiments(run: PaperRun) -> dict[str, Any]:
    """What the experiments say that have `data`."""
    listed = {name: (experiment(name).data, result) for name, result in run.experiments.items()}
    return {name: data(result) for name, (data, result) in listed.items() if data}

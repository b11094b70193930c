"""What `flexhex run` shows in the terminal, or the same as JSON."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

from rich.console import Console

from flexhex.experiments import experiment
from flexhex.identify.view import warn_of
from flexhex.output.tables import Column, console, table
from flexhex.run.outcome import PaperRun, Rows, figure_rows
from flexhex.simulate.view import print_faults, speed_table
from flexhex.simulation.metrics import figure_columns

MOST_ROWS = 12
"""Rows of an experiment that the terminal shows."""
TITLE = Column("title", "")
TABLE_COLUMNS = (TITLE, *figure_columns())
ACTUATOR_COLUMNS = TABLE_COLUMNS[:3]
VARIANT_COLUMNS = (TITLE, Column("plant", "plant"), *figure_columns(2, 5)[:2])
IS_MODEL = (
    "{file} has no truth file {truth}: the simulated machine is its model (plant.fmu), so no model"
    " error, noise or drift is part of these figures."
)


def print_run(run: PaperRun, report: Path) -> None:
    """Table I, variants, time per FMU, experiments, where files are, and the summary."""
    out = console()
    if run.table:
        _print_table(out, run)
    for name, result in run.experiments.items():
        chosen = experiment(name)
        rows = chosen.rows(result)
        if len(rows) > MOST_ROWS:
            out.print(f"{chosen.title}: {len(rows)} rows in the report\n")
        else:
            out.print(table(chosen.title, chosen.columns, rows))
    print_faults(out, run.faults)
    out.print(f"results  {run.builder.out / 'runs'}", markup=False)
    out.print(f"report   {report}  (took {run.wall:.0f} s)", markup=False)
    if run.is_model:
        out.print(model_sentence(run), markup=False)
    if run.table:
        out.print(run.summary, markup=False)


def model_sentence(run: PaperRun) -> str:
    """That the simulated machine is its model."""
    from flexhex.fmus.common.machine_file import truth_file

    file = run.builder.machine_file
    return IS_MODEL.format(file=file.name, truth=truth_file(file).name)


def _print_table(out: Console, run: PaperRun) -> None:
    rows = figure_rows(run.table)
    out.print(table("RMS tracking error and feedback torque", TABLE_COLUMNS, rows))
    if run.actuators:
        rows = figure_rows(run.actuators)
        out.print(table("Actuators with their upper arms alone, RMS", ACTUATOR_COLUMNS, rows))
    if run.extra:
        out.print(table("Variants of the loop, RMS", VARIANT_COLUMNS, variant_rows(run)))
    out.print(speed_table(run.adaptive.result, f"Time in each FMU, {run.adaptive.case.title}"))
    if not run.is_model:
        out.print(
            f"{100 * run.share:.1f} % of the adaptive run's feedback torque is repeatable"
            f"{beside(run.table)}: a better model could remove it"
        )
    warn_of(out, run.fit)
    out.print(
        f"p fitted to {run.fit.samples} torque values of another trajectory;"
        f" {len(run.fit.undetermined)} of {len(run.fit.p)} parameters not determined individually\n"
    )


def beside(rows: Rows) -> str:
    """The published share, where there is one."""
    known = rows.published.repeatable_share if rows.published else None
    return "" if known is None else f" (published: {100 * known:.1f} %)"


def variant_rows(run: PaperRun) -> list[dict[str, str | float | None]]:
    """Rows of the variants, with the FMU that stands for the machine."""
    rows = figure_rows(run.extra)
    return [{**row, "plant": f"{o.case.plant}.fmu"} for row, o in zip(rows, run.extra, strict=True)]


def run_json(run: PaperRun, report: Path) -> str:
    """Figures of all cases as JSON: e [urad], tau_fb [N m], positions [um], angles [urad].

    paper, paper_actuators: published figures of this machine, null where there are none.
    """
    cases = {
        o.case.name: vars(o.figures) | {"real_time_factor": o.real_time_factor}
        for o in (*run.table.outcomes, *run.extra)
    }
    alone = {o.case.name: o.figures for o in run.actuators.outcomes}
    data = {
        "cases": cases,
        "actuators": {name: {"e": f.e, "tau_fb": f.tau_fb} for name, f in alone.items()},
        "faults": [asdict(fault) for fault in run.faults],
        "repeatable_share": run.share if run.table else None,
        "undetermined": list(run.fit.undetermined),
        "fit_warnings": list(run.fit.warnings),
        "experiments": _experiments(run),
        "machine_is_its_model": run.is_model,
        "paper": _published(run.table),
        "paper_actuators": _published(run.actuators),
        "report": str(report),
    }
    return json.dumps(data, indent=2)


def _published(rows: Rows) -> dict[str, list[float]] | None:
    known = rows.published
    return {name: list(values) for name, values in known.rows.items()} if known else None


def _experiments(run: PaperRun) -> dict[str, Any]:
    """The experiments that have `data`, by name."""
    listed = {name: (experiment(name).data, result) for name, result in run.experiments.items()}
    return {name: data(result) for name, (data, result) in listed.items() if data}

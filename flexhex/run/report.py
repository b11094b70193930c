"""The report: one HTML file that tells a run as a story and needs no network."""

from __future__ import annotations

from importlib import resources
from pathlib import Path
from typing import Any

from flexhex.experiments import experiment, render
from flexhex.export.diagram import svg
from flexhex.output.page import page_html
from flexhex.output.plots import COLOURS
from flexhex.output.tables import Column, html
from flexhex.run import loop
from flexhex.run.clip import clips, clips_json
from flexhex.run.figures import figures
from flexhex.run.outcome import PaperRun, figure_rows
from flexhex.run.view import (
    ACTUATOR_COLUMNS,
    TABLE_COLUMNS,
    VARIANT_COLUMNS,
    beside,
    model_sentence,
    variant_rows,
)
from flexhex.simulation.cases import SETTLE
from flexhex.simulation.provenance import sentence
from flexhex.ssp.diagram import read_diagram

TEMPLATES = ("report.html.j2", "clips.html.j2", "sections.html.j2")
TITLES = {"feedback": "feedback only", "fixed": "fixed", "adaptive": "adaptive"}
"""Words of the three answers by the name of the case."""
SPEED_COLUMNS = (
    Column("name", "FMU"),
    Column("steps", "steps", number="d"),
    Column("mean_us", "per step", "µs", ".2f"),
    Column("ms_per_s", "per simulated second", "ms", ".2f"),
    Column("share", "share", "%", ".0f"),
)


def write_report(run: PaperRun, path: Path) -> Path:
    """Render the report of a run to `path`."""
    shown = clips(run)
    judged = run.adaptive if run.table else run.fit_outcome
    text = page_html(
        "report.html.j2",
        figures(run),
        {name: text_of(name) for name in TEMPLATES},
        title=f"flexhex report: {run.builder.machine.name}",
        run=run,
        machine=run.builder.machine,
        seconds=judged.result.duration - SETTLE,
        drawing=svg(read_diagram(run.builder.out / "hexapod.ssp")),
        answers=_answers(run) if run.table else [],
        tables=_tables(run),
        clips=clips_json(shown) if shown else "",
        clips_js=text_of("clips.js"),
        model_sentence=model_sentence(run) if run.is_model else "",
        beside=beside(run.table),
        sources=sentence(run.builder.machine_file),
        margins=html(loop.COLUMNS, [vars(loop.margins(run.builder.machine))]),
        faults=run.faults,
        provenance=judged.provenance,
        titles={name: experiment(name).title for name in run.experiments},
        sections={name: render(name, result) for name, result in run.experiments.items()},
    )
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    return path


def text_of(name: str) -> str:
    """A template or script beside this file."""
    return (resources.files(__package__) / name).read_text(encoding="utf-8")


def _answers(run: PaperRun) -> list[dict[str, Any]]:
    """The three figures that answer what was asked; share: length of a bar [%]."""
    most = max(outcome.figures.e for outcome in run.compared)
    return [
        {
            "word": TITLES[outcome.case.name],
            "title": outcome.case.title,
            "e": f"{outcome.figures.e:.1f}",
            "tau": f"{outcome.figures.tau_fb:.4f}",
            "share": f"{100 * outcome.figures.e / most:.1f}",
            "colour": COLOURS[outcome.case.name],
        }
        for outcome in run.compared
    ]


def _tables(run: PaperRun) -> dict[str, Any]:
    """Tables of the report as HTML; those of Table I where it was simulated."""
    if not run.table:
        return {}
    return {
        "table": html(TABLE_COLUMNS, figure_rows(run.table)),
        "actuators": html(ACTUATOR_COLUMNS, figure_rows(run.actuators)),
        "variants": html(VARIANT_COLUMNS, variant_rows(run)),
        "speed": html(SPEED_COLUMNS, _speed(run)),
    }


def _speed(run: PaperRun) -> list[dict[str, Any]]:
    """Time spent in each FMU instance of the adaptive run."""
    outcome = run.adaptive
    rows = []
    for name, spent in outcome.result.times.items():
        rows.append(
            {
                "name": name,
                "steps": spent.steps,
                "mean_us": spent.seconds / max(spent.steps, 1) * 1e6,
                "share": 100 * spent.seconds / outcome.result.wall,
                "ms_per_s": spent.seconds / outcome.case.duration * 1e3,
            }
        )
    return rows

"""Command `run`: the paper's cases from the machine file to the table and the report."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from flexhex.arguments import (
    DEFAULT_MACHINE,
    AsJson,
    MachineFile,
    OutFolder,
    command_line,
    found_machine,
)


def run_command(
    machine: MachineFile = DEFAULT_MACHINE,
    out: OutFolder = Path("out"),
    quick: Annotated[bool, typer.Option("--quick", help="short trajectory")] = False,
    only: Annotated[
        str | None,
        typer.Option(
            help="one part only: table, repeatability, hysteresis, payload, parameters or missing"
        ),
    ] = None,
    json: AsJson = False,
) -> None:
    """Build, fit, simulate the paper's cases, print the table, write the report."""
    from flexhex.output.progress import LiveProgress
    from flexhex.run.paper import paper_run
    from flexhex.run.report import write_report
    from flexhex.run.view import print_run, run_json
    from flexhex.simulation.builder import Builder

    with LiveProgress() as progress:
        builder = Builder(found_machine(machine), out, progress.building)
        found = paper_run(builder, command_line(), quick, progress, only)
        progress.stage("writing the report")
        report = write_report(found, out / "report.html")
    if json:
        print(run_json(found, report))
    else:
        print_run(found, report)

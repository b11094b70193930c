"""Command `run`: the paper's cases from the machine file to the table and the report."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from flexhex.arguments import (
    DEFAULT_MACHINE,
    AsJson,
    MachineFile,
    command_line,
    machine_file_of,
)

FULL, QUICK = Path("out"), Path("out/quick")
"""Where a full run and a quick one write: a quick one replaces no figures of a full one."""


class Only(StrEnum):
    """What `--only` takes: the table, or one experiment."""

    TABLE = "table"
    REPEATABILITY = "repeatability"
    HYSTERESIS = "hysteresis"
    PAYLOAD = "payload"
    PARAMETERS = "parameters"
    MISSING = "missing"


class Keep(StrEnum):
    """What `--keep` takes."""

    NEEDED = "needed"
    ALL = "all"


def run_command(
    machine: MachineFile = DEFAULT_MACHINE,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out",
            "-o",
            help="folder for everything generated [default: out; with --quick out/quick]",
        ),
    ] = None,
    quick: Annotated[
        bool, typer.Option("--quick", help="short trajectory; leaves the files of a full run alone")
    ] = False,
    only: Annotated[Only | None, typer.Option(help="one part of the report only")] = None,
    keep: Annotated[
        Keep,
        typer.Option(help="signals saved in OUT/runs: those that other commands need, or all"),
    ] = Keep.NEEDED,
    json: AsJson = False,
) -> None:
    """Build, fit, simulate the paper's cases, print the table, write the report."""
    from flexhex.output.live import live
    from flexhex.run.paper import paper_run
    from flexhex.run.report import write_report
    from flexhex.run.view import print_run, run_json
    from flexhex.simulation.builder import Builder

    folder = out or (QUICK if quick else FULL)
    with live() as progress:
        builder = Builder(machine_file_of(machine), folder, progress.building)
        part = only.value if only else None
        done = paper_run(builder, command_line(), quick, progress, part, keep is Keep.ALL)
        progress.stage("writing the report")
        report = write_report(done, folder / "report.html")
    if json:
        print(run_json(done, report))
    else:
        print_run(done, report)

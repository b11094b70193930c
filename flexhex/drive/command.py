"""Command `drive`: the adaptive loop on emulated EtherCAT drives."""

from __future__ import annotations

import json as to_json
import signal
import sys
from pathlib import Path
from typing import Annotated

import typer

from flexhex.arguments import DEFAULT_MACHINE, AsJson, MachineFile, OutFolder, machine_file_of


def drive_command(
    seconds: Annotated[float, typer.Option("--duration", "-d", min=0.01, help="time [s]")] = 10.0,
    machine: MachineFile = DEFAULT_MACHINE,
    out: OutFolder = Path("out"),
    json: AsJson = False,
) -> None:
    """Run the adaptive loop on emulated EtherCAT drives; compare and diagnose. Needs root."""
    from flexhex.drive.cable import check_means
    from flexhex.drive.runs import drives
    from flexhex.drive.view import data, show
    from flexhex.fmugen.blocks import BLOCKS
    from flexhex.output.live import live
    from flexhex.simulation.builder import Builder

    check_means()
    # so that being ended removes cable and processes as Ctrl-C does
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    with live() as progress:
        progress.stage("building the FMUs", len(BLOCKS), "FMUs")
        builder = Builder(machine_file_of(machine), out, progress.building)
        ssp = builder.systems()[-1]
        result = drives(builder.machine_file, ssp, seconds, out / "drive", progress.stage)
    if json:
        print(to_json.dumps(data(result), indent=2))
    else:
        show(result)
    if not result.good:
        raise typer.Exit(1)

"""The commands `drive`, the adaptive loop on emulated drives, and `report`, of its recordings."""

from __future__ import annotations

import json as to_json
import signal
import sys
from pathlib import Path
from typing import Annotated

import typer

from flexhex.commands import AsJson


def drive_command(
    seconds: Annotated[float, typer.Option("--duration", "-d", min=0.01, help="time [s]")] = 10.0,
    machine: Annotated[Path, typer.Option("--machine", "-m", help="machine file (TOML)")] = Path(
        "machines/tflex.toml"
    ),
    out: Annotated[Path, typer.Option("--out", "-o", help="folder of the FMUs")] = Path("out"),
    json: AsJson = False,
) -> None:
    """Run the adaptive loop on emulated EtherCAT drives; compare and diagnose. Wants root."""
    from flexhex.build import Builder
    from flexhex.cli import found_machine
    from flexhex.console import LiveProgress
    from flexhex.drive.cable import check_means
    from flexhex.drive.runs import drives
    from flexhex.drive.view import data, show

    check_means()
    # so that being ended removes cable and processes as Ctrl-C does
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    with LiveProgress() as progress:
        progress.stage("building the FMUs")
        builder = Builder(found_machine(machine), out, progress.building)
        ssp = builder.systems()[-1]
        found = drives(builder.machine_file, ssp, seconds, out / "drive", progress.stage)
    if json:
        print(to_json.dumps(data(found), indent=2))
    else:
        show(found)
    if not found.good:
        raise typer.Exit(1)


def report_command(
    recording: Annotated[Path, typer.Argument(help="recording of the gateway (CSV)")],
    page: Annotated[Path, typer.Option(help="where the plots go")] = Path("out/recording.html"),
    json: AsJson = False,
) -> None:
    """Tell how a recording of the gateway went: errors, times, states, what was missed, trip."""
    from flexhex.drive.page import data, show, write_recording
    from ssp.recording import read_recording

    found = read_recording(recording)
    written = write_recording(found, str(recording), page)
    if json:
        print(to_json.dumps(data(found) | {"page": str(written)}, indent=2))
    else:
        show(found, str(recording), written)

"""The command `drive`: the adaptive loop on emulated drives, as a table or JSON."""

from __future__ import annotations

import json as to_json
import signal
import sys
from pathlib import Path
from typing import Annotated

import typer
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from flexhex.commands import AsJson
from flexhex.drive import Drives, drives, rows


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
    from flexhex.drive_cable import check_means

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


def data(found: Drives) -> dict[str, object]:
    """All figures, for a program."""
    return {
        "runs": rows(found),
        "trips": {name: driven.trip for name, driven in found.driven.items() if driven.trip},
        "lockstep is the simulation": found.comparisons["lockstep"].equal,
        "largest difference": {n: worst(found, n) for n in found.comparisons},
        "diagnosis": {name: diagnosis.verdict for name, diagnosis in found.found.items()},
        "summary": {name: driven.summary for name, driven in found.driven.items()},
        "written": [str(path) for path in found.written],
    }


def worst(found: Drives, name: str) -> dict[str, float]:
    """Largest difference from the simulation by signal, each in its unit."""
    return {d.signal: d.worst for d in found.comparisons[name].differences}


def show(found: Drives) -> None:
    """The table, and what comparing and diagnosing said."""
    out = Console()
    listed = rows(found)
    title = "The adaptive loop on emulated drives, 4 kHz"
    table = Table(title=title, box=SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    for k, key in enumerate(listed[0]):
        table.add_column(key, justify="right" if k else "left")
    for row in listed:
        table.add_row(*row.values())
    out.print(table)
    for name, driven in found.driven.items():
        if driven.trip:
            out.print(f"{name} tripped: {driven.trip}")
    if found.floor is None:
        out.print("No floor of this computer: cyclictest is not installed (package rt-tests).")
    same = found.comparisons["lockstep"].equal
    words = "equals the simulation, every sample" if same else "is NOT the simulation"
    out.print(f"Lockstep {words}; by the clock, the angles differ by at most", end=" ")
    out.print(f"{1e6 * worst(found, 'clock')['plant.theta']:.1f} µrad.")
    for name, diagnosis in found.found.items():
        notes = "; ".join(diagnosis.notes)
        out.print(
            f"Diagnosis of {name}.csv: {diagnosis.verdict}" + (f" ({notes})" if notes else "")
        )
    out.print("  ".join(str(path) for path in found.written), soft_wrap=True)

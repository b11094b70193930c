"""Command `simulate`: a system description through the multi-rate executor."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from flexhex.arguments import AsJson, command_line


def simulate_command(
    description: Annotated[Path, typer.Argument(metavar="SSP", help="system description (.ssp)")],
    duration: Annotated[
        float, typer.Option("--duration", "-d", help="simulated time in seconds")
    ] = 10.0,
    result: Annotated[
        Path,
        typer.Option(
            "--result", "-r", help="file of the signals: .h5 (HDF5), .csv, .mat or .parquet"
        ),
    ] = Path("result.h5"),
    also: Annotated[
        list[str] | None,
        typer.Option(metavar="SIGNAL", help="log a further signal, e.g. N_F.x (may be repeated)"),
    ] = None,
    json: AsJson = False,
) -> None:
    """Simulate a .ssp, save its signals, show tracking error and feedback torque."""
    from flexhex.output.live import live
    from flexhex.simulate.view import print_simulation, simulation_json
    from flexhex.ssp.executor import run as execute
    from flexhex.ssp.results import check_target, provenance, save
    from flexhex.ssp.signals import DEFAULT

    check_target(result)
    with live() as progress:
        advance = progress.line(description.name, duration)
        found = execute(description, duration, signals=[DEFAULT, *(also or [])], progress=advance)
    path = save(found, result, provenance(command=command_line()))
    if json:
        print(simulation_json(found, path))
    else:
        print_simulation(found, path)

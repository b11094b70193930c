"""Command `simulate`: a system description through the multi-rate executor."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from flexhex.arguments import command_line


def simulate_command(
    description: Annotated[Path, typer.Argument(help="system description (.ssp)")],
    duration: Annotated[
        float, typer.Option("--duration", "-d", help="simulated time in seconds")
    ] = 10.0,
    result: Annotated[Path, typer.Option("--result", "-r", help="HDF5 file")] = Path("result.h5"),
    also: Annotated[list[str] | None, typer.Option(help="further signals, e.g. N_F.x")] = None,
) -> None:
    """Simulate a .ssp and save its signals."""
    from flexhex.output.live import live
    from flexhex.simulate.view import print_speed
    from flexhex.ssp.executor import run as execute
    from flexhex.ssp.results import provenance, save
    from flexhex.ssp.signals import DEFAULT

    with live() as progress:
        advance = progress.line(description.name, duration)
        found = execute(description, duration, signals=[DEFAULT, *(also or [])], progress=advance)
    save(found, result, provenance(command=command_line()))
    print_speed(found)
    print(result)

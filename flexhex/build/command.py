"""Command `build`: the FMUs and system descriptions of a machine."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from flexhex.arguments import (
    DEFAULT_MACHINE,
    PLATFORMS,
    MachineFile,
    OutFolder,
    listed_values,
    machine_file_of,
)


def build_command(
    machine: MachineFile = DEFAULT_MACHINE,
    out: OutFolder = Path("out"),
    platform: Annotated[
        str | None,
        typer.Option(
            help=f"target platforms, comma-separated: {', '.join(PLATFORMS)};"
            " default: this computer",
            autocompletion=lambda incomplete: listed_values(incomplete, PLATFORMS),
        ),
    ] = None,
) -> None:
    """Build the FMUs and system descriptions of a machine."""
    from flexhex.fmugen.blocks import BLOCKS
    from flexhex.fmugen.platforms import wanted
    from flexhex.output.live import live
    from flexhex.simulation.builder import Builder

    platforms = wanted(platform) if platform is not None else ()
    with live() as progress:
        progress.stage("building the FMUs", len(BLOCKS), "FMUs")
        builder = Builder(machine_file_of(machine), out, progress.building, platforms)
        written = builder.systems()
    for path in written:
        print(path)

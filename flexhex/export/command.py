"""Command `export`: a .ssp for other tools."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

import typer

from flexhex.arguments import (
    DEFAULT_MACHINE,
    PLATFORMS,
    MachineFile,
    OutFolder,
    Trajectory,
    listed_values,
    machine_file_of,
)
from flexhex.fmus.common.errors import UsageError

TOOLS = ("cofmupy", "maestro", "osp")
"""What `--for` takes."""


def export_command(
    description: Annotated[Path, typer.Argument(metavar="SSP", help="system description (.ssp)")],
    tool: Annotated[
        str | None,
        typer.Option(
            "--for",
            help=f"FMUs and wiring for one of {', '.join(TOOLS)}",
            autocompletion=lambda incomplete: listed_values(incomplete, TOOLS),
        ),
    ] = None,
    container: Annotated[
        bool, typer.Option("--container", help="controller.fmu, the whole controller as one FMU")
    ] = False,
    variables: Annotated[
        bool, typer.Option("--variables", help="variables.csv, all variables of all FMUs")
    ] = False,
    trajectory: Trajectory = None,
    machine: MachineFile = DEFAULT_MACHINE,
    platform: Annotated[
        str | None,
        typer.Option(
            "--platform",
            help="computers of new FMUs, as in `build`",
            autocompletion=lambda incomplete: listed_values(incomplete, PLATFORMS),
        ),
    ] = None,
    diagram: Annotated[bool, typer.Option("--diagram", help="the system drawn, as SVG")] = False,
    duration: Annotated[
        float, typer.Option("--duration", "-d", min=0.0, help="end time in Maestro's files [s]")
    ] = 10.0,
    out: OutFolder = Path("out/export"),
) -> None:
    """Write files for other tools: their own wiring formats, the controllers as one FMU, tables."""
    from flexhex.export.container import export_container
    from flexhex.export.diagram import export_diagram
    from flexhex.export.variables import export_variables
    from flexhex.export.wiring import export_wiring
    from flexhex.fmugen.platforms import wanted
    from flexhex.trajectory.variant import with_trajectory

    if not math.isfinite(duration):
        raise UsageError(f"--duration {duration:g}: must be a number of seconds")
    if platform is not None and not container and trajectory is None:
        text = "--platform is for --container and --trajectory: the other files fit every computer"
        raise UsageError(text)
    if machine != DEFAULT_MACHINE and trajectory is None:
        raise UsageError("--machine is for --trajectory: a .ssp holds its machine")
    platforms = wanted(platform) if platform else ()
    written: list[Path] = []
    if trajectory is not None:
        variant = with_trajectory(description, trajectory, machine_file_of(machine), out, platforms)
        description = variant.path
        written.append(description)
    if tool:
        files = export_wiring(description, out / tool, tool, duration)
        written += [path for path in files if path.suffix != ".fmu"]
    if container:
        written += export_container(description, out, platforms)
    if variables:
        written.append(export_variables([description], out / "variables.csv"))
    if diagram:
        written.append(export_diagram(description, out / f"{description.stem}.svg"))
    if not written:
        raise UsageError(
            "nothing to export: add --trajectory FILE, --for TOOL, --container, --variables or"
            " --diagram"
        )
    for path in written:
        print(path)

"""Command `simulate`: a system description through the multi-rate executor."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from flexhex.arguments import (
    DEFAULT_MACHINE,
    AsJson,
    MachineFile,
    Trajectory,
    command_line,
    machine_file_of,
)
from flexhex.fmus.common.errors import UsageError

DURATION = 10.0
"""Simulated time [s] where neither the user nor a trajectory says one."""


def simulate_command(
    description: Annotated[Path, typer.Argument(metavar="SSP", help="system description (.ssp)")],
    duration: Annotated[
        float | None,
        typer.Option(
            "--duration",
            "-d",
            help=f"simulated time in seconds; default {DURATION:g}, or all of the trajectory",
        ),
    ] = None,
    result: Annotated[
        Path,
        typer.Option(
            "--result", "-r", help="file of the signals: .h5 (HDF5), .csv, .mat, .parquet or .mcap"
        ),
    ] = Path("result.h5"),
    also: Annotated[
        list[str] | None,
        typer.Option(metavar="SIGNAL", help="log a further signal, e.g. N_F.x (may be repeated)"),
    ] = None,
    given: Annotated[
        list[str] | None,
        typer.Option(
            "--parameter",
            "-p",
            metavar="NAME=VALUE",
            help="set a parameter over what the .ssp says, e.g. reference.seed=3 or"
            " reference.kind=chirp (may be repeated)",
        ),
    ] = None,
    trajectory: Trajectory = None,
    machine: MachineFile = DEFAULT_MACHINE,
    json: AsJson = False,
) -> None:
    """Simulate a .ssp, save its signals, show tracking error and feedback torque."""
    import tempfile

    from flexhex.output.live import live
    from flexhex.simulate.view import print_simulation, simulation_json
    from flexhex.ssp.executor import run as execute
    from flexhex.ssp.results import check_target, provenance, save
    from flexhex.ssp.signals import DEFAULT

    check_target(result)
    values = parameters_in(given or [])
    if machine != DEFAULT_MACHINE and trajectory is None:
        raise UsageError("--machine is for --trajectory: a .ssp holds its machine")
    with tempfile.TemporaryDirectory() as folder, live() as progress:
        seconds = DURATION if duration is None else duration
        if trajectory is not None:
            from flexhex.trajectory.variant import with_trajectory

            variant = with_trajectory(
                description, trajectory, machine_file_of(machine), Path(folder)
            )
            description = variant.path
            seconds = variant.end if duration is None else duration
        advance = progress.line(description.name, seconds)
        simulated = execute(
            description,
            seconds,
            signals=[DEFAULT, *(also or [])],
            progress=advance,
            parameters=values,
        )
    path = save(simulated, result, provenance(command=command_line()))
    if json:
        print(simulation_json(simulated, path))
    else:
        print_simulation(simulated, path)


def parameters_in(given: Sequence[str]) -> dict[str, str | list[str]]:
    """Values by name from `reference.kind=chirp`, `reference.amplitude=0.1,0.2,0.1,0.2,0.1,0.2`.

    UsageError for a text without name or value, and for a name that is there twice.
    """
    parameters: dict[str, str | list[str]] = {}
    for text in given:
        name, _, value = (part.strip() for part in text.partition("="))
        if not (name and value):
            raise UsageError(f"--parameter {text!r}: must be NAME=VALUE, as reference.seed=3")
        if name in parameters:
            raise UsageError(f"--parameter {text!r}: {name} has a value already")
        parameters[name] = value.split(",") if "," in value else value
    return parameters

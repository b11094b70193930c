"""Command `identify`: the parameters of a machine by least squares from logs."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from flexhex.arguments import DEFAULT_MACHINE, AsJson, MachineFile, found_machine
from flexhex.log_options import Rename, TorqueConstant, Unit, log_options


def identify_command(
    logs: Annotated[
        list[Path], typer.Argument(metavar="LOG", help="logs of one machine (CSV, HDF5, MAT)")
    ],
    machine: MachineFile = DEFAULT_MACHINE,
    settle: Annotated[
        float,
        typer.Option(metavar="SECONDS", help="left out at the start of each log", min=0.0, max=1e6),
    ] = 2.0,
    every: Annotated[
        bool, typer.Option("--all", help="show all parameters, the cogging amplitudes as well")
    ] = False,
    write: Annotated[
        Path | None,
        typer.Option(
            "--write",
            "-w",
            metavar="FILE",
            help="write a machine file with the fitted values (.toml), or all values with their"
            " standard deviations (.csv, .json)",
        ),
    ] = None,
    torque_constant: TorqueConstant = None,
    unit: Unit = None,
    rename: Rename = None,
    json: AsJson = False,
) -> None:
    """Fit the 162 parameters to logs by least squares."""
    from flexhex.diagnosis.identify import fit
    from flexhex.diagnosis.logs import read_log
    from flexhex.fmus.common.machine_file import load_machine
    from flexhex.identify.view import fit_json, print_fit
    from flexhex.identify.write import checked_target, write_fit

    file = found_machine(machine)
    if write is not None:
        checked_target(write, file)
    given = log_options(torque_constant, unit or [], rename or [])
    described = load_machine(file)
    found = fit(described, [read_log(path, given) for path in logs], settle)
    left_out = [] if write is None else write_fit(write, file, described, found, logs)
    if json:
        print(fit_json(described, found))
    else:
        print_fit(described, found, every)
    for text in left_out:
        print(f"{write}: {text}", file=sys.stderr)
    if write is not None:
        print(f"written  {write}", file=sys.stderr if json else sys.stdout)

"""Command `identify`: the parameters of a machine by least squares from logs."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from flexhex.arguments import DEFAULT_MACHINE, AsJson, machine_file_of
from flexhex.base_options import Base, Joints, OwnEffects, Tolerances, base_options, read_of
from flexhex.diagnose.options import once_each, refuse_inputs
from flexhex.fmus.common.errors import UsageError
from flexhex.identify.folder import NAME, beside, target
from flexhex.log_options import Motor, Rename, TorqueConstant, Unit, log_options

if TYPE_CHECKING:
    from flexhex.diagnosis.prepare import Options

SETTLE = 2.0
"""What is left out at the start of a log of the hexapod [s]."""


def identify_command(
    logs: Annotated[
        list[Path],
        typer.Argument(metavar="LOG...", help="logs of one machine: CSV, HDF5, MAT, bags of ROS 2"),
    ],
    held_out: Annotated[
        list[Path] | None,
        typer.Option(
            metavar="LOG...",
            help="logs that are not fitted: the error on them is shown; takes all words up to the"
            " next option",
        ),
    ] = None,
    machine: Annotated[
        Path | None, typer.Option("--machine", "-m", help="machine file (TOML) of a hexapod")
    ] = None,
    base: Base = "hexapod",
    joints: Joints = "",
    tolerance: Tolerances = None,
    settle: Annotated[
        float | None,
        typer.Option(
            metavar="SECONDS",
            help="left out at the start of each log; default: 2 of a hexapod, else as much as the"
            " base model says",
            min=0.0,
            max=1e6,
        ),
    ] = None,
    every: Annotated[
        bool, typer.Option("--all", help="show all parameters, also those that are not determined")
    ] = False,
    diagnosis: Annotated[
        Path | None,
        typer.Option(
            "--diagnosis",
            metavar="FILE.json",
            help="diagnosis.json that `diagnose` wrote: its effects are fitted, too",
        ),
    ] = None,
    effect: OwnEffects = None,
    write: Annotated[
        Path | None,
        typer.Option(
            "--write",
            "-w",
            metavar="FILE",
            help="write the fitted values into a machine file (.toml) or a robot's file of the same"
            " kind (.urdf, .xml), or all of them with intervals (.csv, .json)",
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out",
            "-o",
            metavar="FOLDER",
            help="write all of it into a folder: identified.json, of a robot's or a machine's file"
            " identified.urdf (.xml, .toml), a page with plots (not of the hexapod)",
        ),
    ] = None,
    fmu: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.fmu",
            help="build an FMU of the identified inverse dynamics: feedforward of any controller",
        ),
    ] = None,
    motion: Annotated[
        Path | None,
        typer.Option(
            "--next",
            metavar="FILE.csv",
            help="write a motion that would determine more, within what the logs have shown",
        ),
    ] = None,
    torque_constant: TorqueConstant = None,
    motor: Motor = None,
    unit: Unit = None,
    rename: Rename = None,
    json: AsJson = False,
) -> None:
    """Fit the parameters of a hexapod, a robot, axes or a model of your own to logs."""
    validation = held_out or []
    once_each(logs, validation)
    options, file = base_options(
        base,
        machine,
        joints,
        tolerance,
        log_options(torque_constant, unit or [], rename or [], motor),
        effect,
    )
    if effect and diagnosis is None:
        raise UsageError("--effect: fitted is what a diagnosis has found: --diagnosis FILE.json")
    option, write = "--out" if write is None else "--write", target(write, out, base)
    page = out / f"{NAME}.html" if out else None
    made = {path: option for path in [*beside(write), *filter(None, [page])]}
    made |= {path: name for path, name in ((fmu, "--fmu"), (motion, "--next")) if path}
    read = [*logs, *validation, *read_of(options, file), *filter(None, [diagnosis])]
    refuse_inputs(made, read)
    if base != "hexapod":
        from flexhex.identify.any_base import Targets, identify_other

        targets = Targets(write, fmu, motion, page)
        identify_other(logs, validation, options, settle, targets, json, every, diagnosis)
        return
    if diagnosis is not None:
        raise UsageError(
            f"--diagnosis {diagnosis}: not for the hexapod: `flexhex diagnose --apply` adds it"
        )
    if motion is not None:
        raise UsageError(
            f"--next {motion}: not for the hexapod: `flexhex diagnose --isolability` judges motions"
        )
    if fmu is not None:
        raise UsageError(
            f"--fmu {fmu}: the hexapod has feedforward.fmu: --write my.toml, then"
            " `flexhex build --machine my.toml`"
        )
    _hexapod(
        logs, validation, machine_file_of(file or DEFAULT_MACHINE), options,
        SETTLE if settle is None else settle, write, json, every,
    )  # fmt: skip


def _hexapod(
    logs: list[Path],
    validation: list[Path],
    file: Path,
    options: Options,
    settle: float,
    write: Path | None,
    json: bool,
    every: bool,
) -> None:
    from flexhex.diagnosis.estimation.identify import fit
    from flexhex.diagnosis.logs import read_log
    from flexhex.fmus.common.machine_file import load_machine
    from flexhex.identify.view import fit_json, print_fit
    from flexhex.identify.write import checked_target, write_fit

    if validation:
        raise UsageError(
            "--held-out: not for the hexapod: `flexhex diagnose --held-out` judges its model"
        )
    if options.tolerance:
        raise UsageError(
            "--tolerance: the hexapod is fitted without its file's values: take it out"
        )
    if write is not None:
        checked_target(write, file)
    described = load_machine(file)
    fitted = fit(described, [read_log(path, options.log) for path in logs], settle)
    left_out = [] if write is None else write_fit(write, file, described, fitted, logs)
    if json:
        print(fit_json(described, fitted))
    else:
        print_fit(described, fitted, every)
    for text in left_out:
        print(f"{write}: {text}", file=sys.stderr)
    if write is not None:
        print(f"written  {write}", file=sys.stderr if json else sys.stdout)

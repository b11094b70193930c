"""Command `view`: runs as a page, the machine in 3D beside its signals."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from flexhex.arguments import DEFAULT_MACHINE, machine_file_of
from flexhex.base_options import Joints, Tolerances, base_options
from flexhex.log_options import Motor, Rename, TorqueConstant, Unit, log_options

if TYPE_CHECKING:
    from flexhex.fmus.common.machine.machine import Machine


def view_command(
    runs: Annotated[
        list[Path],
        typer.Argument(
            metavar="RUN...",
            help="results, recordings of the gateway, or measured logs; of two, the second is a"
            " ghost, of more, the page shows one at a time",
        ),
    ],
    machine: Annotated[
        Path | None, typer.Option("--machine", "-m", help="machine file (TOML) of a hexapod")
    ] = None,
    base: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="whose logs these are, as `diagnose` takes it: a robot's file (.urdf, MJCF .xml,"
            " .sdf, .toml), FILE.py:NAME, axis, hexapod; it is fitted to them, and the page shows"
            " what it leaves of the torques",
        ),
    ] = None,
    held_out: Annotated[
        list[Path] | None,
        typer.Option(
            metavar="RUN...",
            help="with --base: logs that it is not fitted to; takes all words up to the next"
            " option",
        ),
    ] = None,
    joints: Joints = "",
    tolerance: Tolerances = None,
    torque_constant: TorqueConstant = None,
    motor: Motor = None,
    unit: Unit = None,
    rename: Rename = None,
    begin: Annotated[float, typer.Option("--from", help="show from this time on [s]")] = 0.0,
    end: Annotated[
        float | None, typer.Option("--to", help="show up to this time [s]; default: all")
    ] = None,
    page: Annotated[Path, typer.Option(help="where the page goes")] = Path("out/view.html"),
    live: Annotated[
        bool, typer.Option("--live", help="follow a recording that the gateway still writes")
    ] = False,
    port: Annotated[
        int, typer.Option(help="with --live: where the page is served", min=0, max=65535)
    ] = 4851,
    show: Annotated[bool, typer.Option("--open", help="open the page in the browser")] = False,
) -> None:
    """Show runs in the browser: the machine in 3D beside its signals, in one offline file."""
    from flexhex.diagnose.options import once_each
    from flexhex.fmus.common.errors import UsageError
    from flexhex.fmus.common.machine_file import load_machine
    from flexhex.view.data import page_data
    from flexhex.view.page import write_view
    from flexhex.view.shapes import of_machine
    from flexhex.view.sources import load_sources

    logs = log_options(torque_constant, unit or [], rename or [], motor)
    if live:
        if len(runs) > 1:
            raise UsageError("--live follows one recording: leave the others out")
        if base is not None:
            raise UsageError("--live follows a hexapod's recording: take --base out")
        _follow(runs[0], load_machine(machine_file_of(machine or DEFAULT_MACHINE)), port, show)
        return
    if base is None:
        of_a_base = {"--joints": joints, "--tolerance": tolerance, "--held-out": held_out}
        for option in (name for name, given in of_a_base.items() if given):
            raise UsageError(f"{option}: say whose, --base robot.urdf")
        drawn, said = of_machine(load_machine(machine_file_of(machine or DEFAULT_MACHINE))), ""
        shown = load_sources(runs, logs, drawn)
    else:
        from flexhex.view.measured import measured_runs

        once_each(runs, held_out or [])
        options, file = base_options(base, machine, joints, tolerance, logs)
        shown, drawn, said = measured_runs(runs, file, options, held_out or [])
    data = page_data(shown, drawn, (begin, math.inf if end is None else end))
    written = write_view(page, " and ".join(one.name for one in shown), {**data, "said": said})
    if said:
        print(f"note   {said}")
    print(f"page   {written} ({written.stat().st_size / 1e6:.1f} MB)")
    if show:
        typer.launch(written.absolute().as_uri())


def _follow(path: Path, machine: Machine, port: int, show: bool) -> None:
    """Serve the page of a recording until Ctrl-C."""
    from flexhex.view.live import Live, server, wait_for_rows

    followed = Live(path, machine)
    with server(followed, port) as serving:
        address = f"http://127.0.0.1:{serving.server_port}/"
        print(f"page   {address}  follows {path}; Ctrl-C ends it", flush=True)
        wait_for_rows(followed)
        if show:
            typer.launch(address)
        serving.serve_forever()

"""Command `view`: one or two runs as a page, the machine in 3D beside its signals."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from flexhex.arguments import DEFAULT_MACHINE, MachineFile, found_machine

if TYPE_CHECKING:
    from flexhex.fmus.common.machine.machine import Machine


def view_command(
    run: Annotated[
        Path,
        typer.Argument(
            metavar="RUN", help="result, recording of the gateway, or measured log of a hexapod"
        ),
    ],
    second: Annotated[
        Path | None, typer.Argument(metavar="[RUN]", help="a second run, shown as a ghost")
    ] = None,
    machine: MachineFile = DEFAULT_MACHINE,
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
    """Show a run in the browser: the machine in 3D beside its signals, in one offline file."""
    from flexhex.fmus.common.errors import UsageError
    from flexhex.fmus.common.machine_file import load_machine
    from flexhex.view.data import page_data
    from flexhex.view.page import write_view
    from flexhex.view.sources import load_sources

    made = load_machine(found_machine(machine))
    if live:
        if second is not None:
            raise UsageError("--live follows one recording: leave the second run out")
        _follow(run, made, port, show)
        return
    runs = load_sources([run] if second is None else [run, second])
    data = page_data(runs, made, (begin, math.inf if end is None else end))
    title = " and ".join(one.name for one in runs)
    written = write_view(page, title, data)
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

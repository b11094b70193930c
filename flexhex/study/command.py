"""Command `study`: Monte Carlo simulation of the loop on machines drawn at random."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import typer

from flexhex.arguments import (
    DEFAULT_MACHINE,
    AsJson,
    MachineFile,
    listed_values,
    machine_file_of,
)

KINDS = ("noise", "payload", "age", "drift", "truth", "trajectory")
"""What `--vary` takes."""


def study_command(
    runs: Annotated[int, typer.Option("--runs", "-n", help="draws, each run as both cases")] = 20,
    duration: Annotated[float, typer.Option("--duration", "-d", help="judged time [s]")] = 10.0,
    seed: Annotated[int, typer.Option(help="seed of all draws")] = 1,
    vary: Annotated[
        str | None,
        typer.Option(
            help=f"comma-separated, of {', '.join(KINDS)}; default: noise,payload,age,drift",
            autocompletion=lambda incomplete: listed_values(incomplete, KINDS),
        ),
    ] = None,
    payload: Annotated[float, typer.Option(help="largest payload [kg]")] = 1.0,
    age: Annotated[float, typer.Option(help="longest time since switched on [s]")] = 2400.0,
    jobs: Annotated[int | None, typer.Option("--jobs", "-j", help="processes at a time")] = None,
    dask: Annotated[str | None, typer.Option(help="scheduler, tcp://host:8786")] = None,
    name: Annotated[str, typer.Option(help="figures go to OUT/study/NAME.jsonl")] = "study",
    machine: MachineFile = DEFAULT_MACHINE,
    out: Annotated[Path, typer.Option("--out", "-o", help="where `flexhex run` wrote")] = Path(
        "out"
    ),
    json: AsJson = False,
) -> None:
    """Simulate many machines drawn at random (Monte Carlo). The same command resumes a study."""
    from flexhex.output.interrupt import STOPPED
    from flexhex.output.live import live
    from flexhex.study.draws import StudyPlan, varied_of
    from flexhex.study.pool import local, over_dask
    from flexhex.study.store import Store, file_name
    from flexhex.study.tasks import carry_out, tasks
    from flexhex.study.view import print_result, result_json, write_result

    file = machine_file_of(machine)
    plan = StudyPlan(runs, duration, seed, varied_of(vary, file), payload, age)
    pool = over_dask(dask) if dask else local(jobs or os.cpu_count() or 1)
    folder = out / "study"
    listed = tasks(plan, file, out)
    store = Store(folder / file_name(name, "jsonl"))
    with live() as progress:
        advance = progress.line(f"study of {runs} draws", len(listed), "runs")
        try:
            result = carry_out(plan, listed, store, pool, advance)
        except KeyboardInterrupt:
            typer.echo(f"flexhex: stopped; finished runs are in {store.path}", err=True)
            raise typer.Exit(STOPPED) from None
    page = write_result(result, folder / file_name(name, "html"))
    if json:
        print(result_json(result, store.path, page))
    else:
        print_result(result, store.path, page)
    if result.failed:
        raise typer.Exit(1)

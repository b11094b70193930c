"""Command `study`: the same loop on many machines drawn at random."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import typer

from flexhex.arguments import DEFAULT_MACHINE, AsJson, MachineFile, found_machine


def study_command(
    runs: Annotated[int, typer.Option("--runs", "-n", help="draws, each run as both cases")] = 20,
    duration: Annotated[float, typer.Option("--duration", "-d", help="judged time [s]")] = 10.0,
    seed: Annotated[int, typer.Option(help="seed of all draws")] = 1,
    vary: Annotated[
        str, typer.Option(help="of noise, payload, age, drift, truth, trajectory")
    ] = "noise,payload,age,drift",
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
    """Simulate many machines drawn at random (Monte Carlo); the same command goes on later."""
    from flexhex.study.draws import Plan, study, tasks
    from flexhex.study.pool import local, over_dask
    from flexhex.study.store import Store, file_name
    from flexhex.study.view import bar, found_json, print_found, write_found

    varied = tuple(dict.fromkeys(word.strip() for word in vary.split(",") if word.strip()))
    plan = Plan(runs, duration, seed, varied, payload, age)
    pool = over_dask(dask) if dask else local(jobs or os.cpu_count() or 1)
    folder = out / "study"
    listed = tasks(plan, found_machine(machine), out)
    store = Store(folder / file_name(name, "jsonl"))
    with bar() as progress:
        line = progress.add_task(f"{runs} draws, {len(listed)} runs", total=len(listed))
        try:
            found = study(
                plan, listed, store, pool, lambda n, total: progress.update(line, completed=n)
            )
        except KeyboardInterrupt:
            progress.stop()
            typer.echo(f"flexhex: stopped; finished runs are in {store.path}", err=True)
            raise typer.Exit(130) from None
    page = write_found(found, folder / file_name(name, "html"))
    if json:
        print(found_json(found, store.path, page))
    else:
        print_found(found, store.path, page)
    if found.failed:
        raise typer.Exit(1)

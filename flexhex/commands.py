"""Commands `compare` and `study`, registered by `flexhex.cli`; heavy imports wait for a call."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import typer

AsJson = Annotated[bool, typer.Option("--json", help="result as JSON on stdout")]


def compare_command(
    first: Annotated[
        Path, typer.Argument(metavar="RUN", help="result (HDF5), or recording of the gateway (CSV)")
    ],
    second: Annotated[Path, typer.Argument(metavar="RUN", help="another one")],
    atol: Annotated[float, typer.Option(help="tolerance of all signals, each in its unit")] = 0.0,
    rtol: Annotated[float, typer.Option(help="the same, times a signal's largest value")] = 1e-9,
    tol: Annotated[
        list[str] | None, typer.Option(help="tolerance of one signal: plant.theta=1e-6")
    ] = None,
    common: Annotated[
        bool, typer.Option("--common", help="judge only signals and time that both have")
    ] = False,
    plots: Annotated[int, typer.Option(min=0, help="signals on the page, 0: no page")] = 6,
    page: Annotated[Path, typer.Option(help="where overlays and differences go")] = Path(
        "out/compare.html"
    ),
    json: AsJson = False,
) -> None:
    """Compare two results signal by signal: exit code 0 equal within tolerance, 1 not."""
    from flexhex.compare.results import Tolerance, compare, tolerances
    from flexhex.compare.view import comparison_json, print_comparison, write_comparison
    from ssp.recording import load_recording
    from ssp.results import load

    a, b = (load_recording(p) if p.suffix.lower() == ".csv" else load(p) for p in (first, second))
    found = compare(a, b, Tolerance(atol, rtol, tolerances(tol or [])), common)
    names = (str(first), str(second))
    written = write_comparison(found, a, b, names, plots, page) if plots else None
    if json:
        print(comparison_json(found, written))
    else:
        print_comparison(found, written)
    if not found.equal:
        raise typer.Exit(1)


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
    machine: Annotated[Path, typer.Option("--machine", "-m", help="machine file (TOML)")] = Path(
        "machines/tflex.toml"
    ),
    out: Annotated[Path, typer.Option("--out", "-o", help="where `flexhex run` wrote")] = Path(
        "out"
    ),
    json: AsJson = False,
) -> None:
    """Simulate many machines drawn at random (Monte Carlo); the same command goes on later."""
    from flexhex.cli import found_machine
    from flexhex.montecarlo.pool import local, over_dask
    from flexhex.montecarlo.report import bar, found_json, print_found, write_found
    from flexhex.montecarlo.store import Store, file_name
    from flexhex.montecarlo.study import Plan, study, tasks

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

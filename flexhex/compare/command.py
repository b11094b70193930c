"""Command `compare`: two runs by their tracking, then signal by signal."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from flexhex.arguments import AsJson


def compare_command(
    first: Annotated[
        Path,
        typer.Argument(metavar="FIRST", help="result (.h5, .csv), or recording of the gateway"),
    ],
    second: Annotated[Path, typer.Argument(metavar="SECOND", help="the run to compare it with")],
    atol: Annotated[float, typer.Option(help="tolerance of all signals, each in its unit")] = 0.0,
    rtol: Annotated[
        float, typer.Option(help="tolerance relative to each signal's largest value")
    ] = 1e-9,
    tol: Annotated[
        list[str] | None,
        typer.Option(metavar="SIGNAL=VALUE", help="tolerance of one signal: plant.theta=1e-6"),
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
    """Compare two runs: tracking error and feedback torque, then every signal.

    Exit code 0: equal within tolerance. 1: different. 2: wrong usage. 3: a file cannot be read.
    """
    from flexhex.compare.page import write_comparison
    from flexhex.compare.results import Tolerance, compare, tolerances
    from flexhex.compare.runs import figures, load_runs
    from flexhex.compare.view import comparison_json, print_comparison

    limits = Tolerance(atol, rtol, tolerances(tol or []))
    runs = load_runs(first, second)
    comparison = compare(runs[0].result, runs[1].result, limits, common)
    judged = figures(*runs)
    written = write_comparison(comparison, judged, runs, plots, page) if plots else None
    if json:
        print(comparison_json(comparison, judged, runs, written))
    else:
        print_comparison(comparison, judged, runs, written)
    if not comparison.equal:
        raise typer.Exit(1)

"""Command `compare`: two results signal by signal."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from flexhex.arguments import AsJson


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
    from flexhex.recording import load_recording
    from flexhex.ssp.results import load

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

"""Command `plot`: signals of a run in the terminal and on an offline page."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

import typer


def plot_command(
    run: Annotated[
        Path,
        typer.Argument(metavar="RUN", help="result, recording of the gateway, or measured log"),
    ],
    signals: Annotated[
        list[str] | None,
        typer.Argument(metavar="[SIGNAL]...", help="plant.theta or plant.theta[2]; none: a list"),
    ] = None,
    begin: Annotated[float, typer.Option("--from", help="from this time on [s]")] = 0.0,
    end: Annotated[
        float | None, typer.Option("--to", help="up to this time [s]; default: all")
    ] = None,
    page: Annotated[Path, typer.Option(help="where the plots go")] = Path("out/plot.html"),
) -> None:
    """Plot signals of a run in the terminal and on a page; without any, list them."""
    from flexhex.plot.draw import chosen, listing, overview, write_plots
    from flexhex.view.sources import load_source

    result = load_source(run)
    if not signals:
        listing(result)
        return
    picked = chosen(result, signals, (begin, math.inf if end is None else end))
    overview(picked)
    print(f"page   {write_plots(picked, str(run), page)}")

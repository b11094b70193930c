"""Command `convert`: results, recordings and logs as HDF5, CSV, MAT, Parquet or MCAP."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def convert_command(
    source: Annotated[
        Path,
        typer.Argument(metavar="RUN", help="result, recording of the gateway, or measured log"),
    ],
    target: Annotated[
        Path, typer.Argument(metavar="FILE", help="what to write: .h5, .csv, .mat, .parquet, .mcap")
    ],
) -> None:
    """Write a run in another format, in SI units. All of them read back exactly."""
    from flexhex.fmus.common.errors import UsageError
    from flexhex.ssp.results import check_target, save
    from flexhex.view.sources import load_source

    check_target(target)
    if target.exists() and source.exists() and target.samefile(source):
        raise UsageError(f"{target}: is the run itself: name another file")
    result = load_source(source)
    path = save(result, target)
    for name, group in result.groups.items():
        print(f"{name:>10}  {group.rows} samples of {', '.join(group.signals)}")
    print(f"result   {path}")

"""Command `report`: how a recording of the gateway went."""

from __future__ import annotations

import json as to_json
from pathlib import Path
from typing import Annotated

import typer

from flexhex.arguments import AsJson


def report_command(
    recording: Annotated[Path, typer.Argument(help="recording of the gateway (CSV)")],
    page: Annotated[Path, typer.Option(help="where the plots go")] = Path("out/recording.html"),
    json: AsJson = False,
) -> None:
    """Summarise a recording of the gateway: errors, timing, states, skipped cycles, trip."""
    from flexhex.recording import read_recording
    from flexhex.report.page import data, show, write_recording
    from flexhex.report.recorded import require

    recorded = read_recording(recording)
    require(recorded, str(recording))
    written = write_recording(recorded, str(recording), page)
    if json:
        print(to_json.dumps(data(recorded) | {"page": str(written)}, indent=2))
    else:
        show(recorded, str(recording), written)

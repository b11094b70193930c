"""`flexhex identify` of any base model but the hexapod: fit, write, show."""

from __future__ import annotations

from pathlib import Path

from rich.console import Console

from flexhex.diagnosis.estimation.identified import identify
from flexhex.diagnosis.prepare import Options
from flexhex.identify.other import identified_json, print_identified, say
from flexhex.identify.write_other import checked_target, write_identified
from flexhex.output.live import live


def identify_other(
    logs: list[Path],
    held_out: list[Path],
    options: Options,
    settle: float | None,
    write: Path | None,
    as_json: bool,
    every: bool,
) -> None:
    """The whole command: fit, write, show."""
    if write is not None:
        checked_target(write, options.base)
    progress = live()
    with progress:
        progress.stage("identifying", unit="steps")
        found = identify(logs, held_out, None, options, settle, progress.steps)
    written = [] if write is None else write_identified(write, found)
    if as_json:
        print(identified_json(found, [str(path) for path in written]))
    else:
        print_identified(found, every)
        for path in written:
            say(Console(), f"written  {path}")

"""`flexhex identify` of any base model but the hexapod: fit, write, show."""

from __future__ import annotations

import sys
from dataclasses import dataclass, replace
from pathlib import Path

from rich.console import Console

from flexhex.diagnose.next import shortened
from flexhex.diagnosis.estimation.excitation import excitation
from flexhex.diagnosis.estimation.found import read_diagnosis
from flexhex.diagnosis.estimation.identified import identify
from flexhex.diagnosis.estimation.inverse import left_out
from flexhex.diagnosis.estimation.records import Identified
from flexhex.diagnosis.hypotheses.own_effect import own_effects
from flexhex.diagnosis.planning.trajectory import write_trajectory
from flexhex.diagnosis.prepare import Options
from flexhex.identify.other import identified_json, print_excitation, print_identified
from flexhex.identify.write_other import (
    checked_fmu,
    checked_motion,
    checked_target,
    write_identified,
)
from flexhex.output.live import live
from flexhex.output.parts import say


@dataclass(frozen=True)
class Targets:
    """Files to be written: the robot's file or a table, an FMU, a motion that determines more, a
    page."""

    values: Path | None = None
    fmu: Path | None = None
    motion: Path | None = None
    page: Path | None = None

    def check(self, base: str) -> None:
        """UsageError or OutputError, before anything is computed."""
        if self.values is not None:
            checked_target(self.values, base)
        if self.fmu is not None:
            checked_fmu(self.fmu)
        if self.motion is not None:
            checked_motion(self.motion)

    def write(self, identified: Identified) -> tuple[list[Path], list[str]]:
        """All of them, and what who uses them must know."""
        written, notes = list[Path](), list[str]()
        if self.values is not None:
            written, notes = write_identified(self.values, identified)
        if self.fmu is not None:
            from flexhex.identify.inverse import write_fmu

            written.append(write_fmu(self.fmu, identified))
        return written, notes


def identify_other(
    logs: list[Path],
    held_out: list[Path],
    options: Options,
    settle: float | None,
    write: Targets,
    as_json: bool,
    every: bool,
    diagnosis: Path | None = None,
) -> None:
    """The whole command: fit, write, show."""
    write.check(options.base)
    more = None if diagnosis is None else read_diagnosis(diagnosis, own_effects(options.effects))
    progress = live()
    with progress:
        progress.stage("identifying", unit="steps")
        identified = identify(logs, held_out, None, options, settle, progress.steps, more)
    if write.fmu is not None:
        identified = replace(
            identified, notes=(*identified.notes, *left_out(identified.estimated.extras))
        )
    written, notes = write.write(identified)
    identified = replace(identified, notes=(*identified.notes, *notes))
    planned = None
    if write.motion is not None:
        planned = excitation(identified)
        written.append(write_trajectory(planned.motion, write.motion))
    if write.page is not None:
        from flexhex.identify.page import write_identified_page

        command = shortened(("flexhex", *sys.argv[1:]))
        files = [*logs, *held_out]
        written.append(write_identified_page(write.page, identified, command, files))
    if as_json:
        print(identified_json(identified, [str(path) for path in written], planned))
    else:
        print_identified(identified, every)
        if planned is not None:
            print_excitation(planned)
        for path in written:
            say(Console(), f"written  {path}")

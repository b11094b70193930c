"""Processor time and memory of `flexhex diagnose`: a hexapod and a single axis, made up.

Logs are written once, into a folder of their own; what is measured is the whole command, one thread
of BLAS, with the memory of its largest process.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from benchmarks.clock import Row, Timing
from flexhex.fmus.common.errors import RunError
from flexhex.fmus.common.machine.machine import Machine
from studies import axes, axes_files
from studies.generator.draw import draw
from studies.generator.inverse import simulate
from studies.generator.write import write

HEXAPOD, AXIS = 3003, 3003
"""Seeds of development: dry friction that the model lacks; one axis with friction and cogging."""
MOST = 3
"""Runs that are measured at most."""
Made = Callable[[Path, Path], list[str]]
"""From folders of the logs and of the truth to the words behind `flexhex diagnose`."""


@dataclass(frozen=True)
class Case:
    """What is diagnosed; required [s], memory [bytes]: what it may take."""

    what: str
    made: Made
    required: float
    memory: float


def hexapod(logs: Path, sealed: Path) -> list[str]:
    """Four trajectories of 20 s at 2 kHz, two passes of each, the last one held out."""
    case = draw(HEXAPOD, 20.0)
    kind, seed = case.trajectories[0]
    case = replace(case, trajectories=((kind, seed + 1), *case.trajectories))
    files = write(case, simulate(case), logs, sealed)
    return [*map(str, files.paths), "--held-out", *map(str, files.held_out)]


def axis(logs: Path, sealed: Path) -> list[str]:
    """Two trajectories of 12 s, two passes of each."""
    files = axes_files.write(replace(axes.draw(AXIS), seconds=12.0), logs, sealed)
    return [*map(str, files.paths), "--base", "axis"]


CASES = {
    "diagnose": Case("diagnose, eight hexapod runs of 20 s at 2 kHz", hexapod, 20.0, 1e9),
    "diagnose axis": Case("diagnose, an axis of 4 x 12 s", axis, 3.0, 1e9),
}


def row_of(key: str) -> Callable[[Machine, int], Row]:
    """How one of CASES is measured, so many times at most."""

    def row(machine: Machine, rounds: int) -> Row:
        case = CASES[key]
        with tempfile.TemporaryDirectory() as folder:
            words = case.made(Path(folder) / "logs", Path(folder) / "truth")
            words = ["diagnose", *words, "--out", f"{folder}/out", "--json"]
            spent = [used(words, Path(folder)) for _ in range(min(rounds, MOST))]
        times, peaks = np.array(spent).T
        timing = Timing(key, float(np.median(times)), float(times.min()))
        note = f"peak memory {peaks.max() / 1e9:.2g} GB, at most {case.memory / 1e9:.2g} GB wanted"
        return Row(key, case.what, [timing], 1e9 * case.required, notes=[note])

    return row


def used(words: Sequence[str], folder: Path) -> tuple[float, float]:
    """User and system time [ns], and the largest memory [bytes] of a flexhex command.

    RunError when it fails; an effect that remains is no failure.
    """
    with (folder / "said").open("w+") as said:
        command = [sys.executable, "-m", "flexhex", *words]
        one = os.environ | {"OPENBLAS_NUM_THREADS": "1"}
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=said, env=one)
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode not in (0, 1):
            said.seek(0)
            raise RunError(f"{' '.join(words)}: exit {process.returncode}: {said.read()[-500:]}")
    unit = 1 if sys.platform == "darwin" else 1024
    return 1e9 * (usage.ru_utime + usage.ru_stime), float(unit * usage.ru_maxrss)

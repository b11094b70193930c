"""Processor time of the commands that people wait for, all of their threads and compilers; of
`make test` the time of the clock, on all cores."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.clock import Row, Timing
from flexhex.fmugen.cache import VARIABLE
from flexhex.fmus.common.errors import RunError
from flexhex.fmus.common.machine.machine import Machine

WARM = 1
"""Runs before, which fill the caches."""


@dataclass(frozen=True)
class Command:
    """A command line behind `flexhex` or another program, and how it is measured.

    required [s]; most: runs that are measured at most; out: it writes files, into an empty folder;
    cold: with an empty cache of FMUs, else with one that a run before has filled; clock: by the
    clock and on all cores.
    """

    what: str
    line: str
    required: float
    most: int = 5
    out: bool = False
    cold: bool = False
    clock: bool = False
    program: tuple[str, ...] = (sys.executable, "-m", "flexhex")


COMMANDS = {
    "help": Command("flexhex --help", "--help", 0.3),
    "check": Command("flexhex check of a machine file", "check machines/tflex.toml", 1.0),
    "warm": Command("flexhex build, FMUs from the cache", "build", 1.0, out=True),
    "cold": Command("flexhex build, empty cache", "build", 15.0, 1, out=True, cold=True),
    "quick": Command(
        "flexhex run --quick, FMUs from the cache", "run --quick", 25.0, 3, out=True
    ),
    "run": Command("make run, FMUs from the cache", "run", 120.0, 1, out=True),
    "test": Command(
        "make test, by the clock", "test", 600.0, 1, cold=True, clock=True, program=("make",)
    ),
}  # fmt: skip


def spent(command: Command, tree: Path) -> float:
    """Time of one run in a working tree [ns]. RunError when it fails."""
    with tempfile.TemporaryDirectory() as folder:
        words = [*command.program, *command.line.split()]
        words += ["--out", folder] if command.out else []
        cache = {VARIABLE: f"{folder}/cache"} if command.cold else {}
        if not command.clock:
            return processor_time(words, tree, cache)
        begin = time.monotonic_ns()
        with every_core():
            processor_time(words, tree, cache)
        return float(time.monotonic_ns() - begin)


@contextmanager
def every_core() -> Iterator[None]:
    """All cores of the computer for what is started meanwhile, where one was chosen before."""
    if not hasattr(os, "sched_setaffinity"):
        yield
        return
    one = os.sched_getaffinity(0)
    os.sched_setaffinity(0, range(os.cpu_count() or 1))
    try:
        yield
    finally:
        os.sched_setaffinity(0, one)


def processor_time(words: Sequence[str], tree: Path, environment: dict[str, str]) -> float:
    """User and system time of a command with its children [ns]. RunError when it fails."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(
        words, cwd=tree, env=os.environ | environment, capture_output=True, text=True, check=False
    )
    if done.returncode:
        said = (done.stderr.strip() or done.stdout.strip())[-500:]
        raise RunError(f"{' '.join(words)}: exit {done.returncode}: {said}")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return 1e9 * (after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)


def row_of(key: str) -> Callable[[Machine, int], Row]:
    """How one of COMMANDS is measured in this working tree, so many times at most."""

    def row(machine: Machine, rounds: int) -> Row:
        command, tree = COMMANDS[key], Path.cwd()
        warm = 0 if command.cold else WARM
        times = [spent(command, tree) for _ in range(warm + min(rounds, command.most))][warm:]
        name = f"{Path(command.program[-1]).name} {command.line}"
        timing = Timing(name, float(np.median(times)), float(np.min(times)))
        return Row(key, command.what, [timing], 1e9 * command.required)

    return row

"""Processor time of `flexhex run --quick` into an empty folder, with FMUs from the cache."""

from __future__ import annotations

import resource
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from benchmarks.clock import Row, Timing
from flexhex.fmus.common.errors import RunError

REQUIRED_NS = 25e9
"""Processor time of the whole command, all of its threads and compilers [ns]."""
WARM, MOST = 1, 3
"""Runs before, which fill the cache; runs that are measured at most."""


def spent(machine_file: Path) -> float:
    """User and system time of one quick run [ns]."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "flexhex", "run", "--quick", "--out", folder]
        done = subprocess.run(
            [*command, "--machine", str(machine_file)], capture_output=True, text=True, check=False
        )
    if done.returncode:
        raise RunError(f"flexhex run --quick: {done.stderr.strip()[-500:]}")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return 1e9 * (after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)


def quick_row(machine_file: Path, rounds: int) -> Row:
    """The first command that a newcomer runs, the second time."""
    times = [spent(machine_file) for _ in range(WARM + min(rounds, MOST))][WARM:]
    timing = Timing("flexhex run --quick", float(np.median(times)), float(np.min(times)))
    return Row("quick", "flexhex run --quick, FMUs from the cache", [timing], REQUIRED_NS)

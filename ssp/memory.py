"""Whether a run's log fits into memory, asked before it is allocated."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

from flexhex.fmus.common.errors import UsageError

SHARE = 0.8
"""Of the free memory that a log may take; the rest is for writing it."""


def check_memory(sizes: Mapping[int, int], n_steps: int, base: float) -> None:
    """UsageError when the logged rows do not fit into the memory that is free.

    sizes: numbers in a row by period [base steps]; n_steps base steps of `base` [s] are run.
    """
    needed = sum(8 * size * (n_steps // period + 1) for period, size in sizes.items())
    room = SHARE * free_memory()
    if needed > room:
        seconds = n_steps * base
        raise UsageError(
            f"a log of {seconds:g} s takes {needed / 1e9:.3g} GB of memory, {room / 1e9:.3g} GB can"
            f" be had: run at most {seconds * room / needed:.2g} s, or log fewer signals"
        )


def free_memory() -> int:
    """Bytes of memory that can be had without swapping, or else of memory altogether."""
    try:
        lines = Path("/proc/meminfo").read_text(encoding="ascii").splitlines()
        return 1024 * next(int(line.split()[1]) for line in lines if "MemAvailable" in line)
    except (OSError, StopIteration):
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")

"""Measuring side by side: one core, short bursts in turn (A B A B ...), medians."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

Run = Callable[[int], float]
"""Do the work so many times; nanoseconds [ns] for one."""
BURST_NS = 2e6


@dataclass(frozen=True)
class Rival:
    """Something that is timed: its name and how to run it; note: what is not like for like."""

    name: str
    run: Run
    note: str = ""


@dataclass(frozen=True)
class Timing:
    """Nanoseconds [ns] for one call: median and least over the bursts."""

    name: str
    median: float
    least: float
    note: str = ""


@dataclass(frozen=True)
class Row:
    """One line of the table. first is ours; ratios are rival / ours.

    required, stretch [ns], or as real-time factors when `faster` says that more is better.
    """

    key: str
    what: str
    timings: Sequence[Timing]
    required: float | None = None
    stretch: float | None = None
    faster: bool = False
    notes: Sequence[str] = field(default_factory=tuple)

    @property
    def ours(self) -> Timing:
        """What the limits are for."""
        return self.timings[0]

    def met(self, limit: float | None) -> bool | None:
        """Whether the median keeps a limit; None without a limit."""
        if limit is None:
            return None
        return self.ours.median >= limit if self.faster else self.ours.median <= limit

    def ratio(self, rival: Timing) -> float:
        """How many times faster ours is than a rival."""
        mine, theirs = self.ours.median, rival.median
        return mine / theirs if self.faster else theirs / mine


def pin(core: int = 0) -> list[int]:
    """Keep this process on one core where the system can; the cores that it had before."""
    if not hasattr(os, "sched_setaffinity"):
        return []
    allowed = sorted(os.sched_getaffinity(0))
    os.sched_setaffinity(0, {allowed[core % len(allowed)]})
    return allowed


def measure(rivals: Sequence[Rival], rounds: int = 25, burst_ns: float = BURST_NS) -> list[Timing]:
    """Time all in turn, `rounds` times; each burst lasts about burst_ns or one call."""
    counts = []
    for rival in rivals:
        rival.run(1)
        counts.append(max(1, round(burst_ns / max(min(rival.run(3), rival.run(3)), 1.0))))
    spent: list[list[float]] = [[] for _ in rivals]
    for _ in range(rounds):
        for k, (rival, count) in enumerate(zip(rivals, counts, strict=True)):
            spent[k].append(rival.run(count))
    return [
        Timing(rival.name, float(np.median(times)), float(np.min(times)), rival.note)
        for rival, times in zip(rivals, spent, strict=True)
    ]

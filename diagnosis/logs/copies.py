"""Runs that are one measurement twice: its noise would repeat, and be taken for an effect."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flexhex.diagnosis.logs.log import Channel, Log
from flexhex.fmus.common.errors import LogError

NEEDED = ("theta", "tau_meas")


def refuse_copies(logs: Sequence[Log]) -> None:
    """LogError when two logs hold the same samples; a machine never repeats its noise."""
    seen: dict[tuple[int, float], list[Log]] = {}
    for log in logs:
        # a sum is a quick look: copies have the same
        key = len(log.tau), float(log.tau.sum())
        for other in seen.setdefault(key, []):
            if all(_same(log[name], other[name]) for name in NEEDED):
                raise LogError(
                    f"{log.name}: the same samples as {other.name}, noise and all: a copy, or"
                    " a simulation without noise; give it once"
                )
        seen[key].append(log)


def _same(a: Channel, b: Channel) -> bool:
    return bool(np.array_equal(a.values, b.values))

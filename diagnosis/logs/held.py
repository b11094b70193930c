"""Values that a logger repeats until the next one comes: it writes faster than they are read."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexhex.diagnosis.logs.log import Channel, Finding

MEASURED = ("theta", "thetad", "tau_meas", "current")
"""Of these a value that stands still is one that was not read; commands are held."""
MOST = 20
"""Largest number of samples for which a value is looked for that stands still."""
REGULAR, EVENTS = 0.99, 100
"""Share of the changes that come so many samples apart, and least number of changes to judge by."""


def fresh(where: str, name: str, channel: Channel) -> tuple[Channel, list[Finding]]:
    """Of values that change every k-th sample alone those that are new: between them the axis moves
    on, and their differences would be zeros and jumps."""
    if name not in MEASURED or channel.breaks:
        return channel, []
    moved = np.zeros(len(channel.values) - 1, dtype=bool)
    for column in channel.values.T:  # one axis at a time: long logs are large
        moved |= column[1:] != column[:-1]
    at = 1 + np.flatnonzero(moved & channel.valid[1:] & channel.valid[:-1])
    if len(at) < EVENTS:
        return channel, []
    for k in range(MOST, 1, -1):
        counts = np.bincount(at % k, minlength=k)
        first = int(np.argmax(counts))
        if counts[first] >= REGULAR * len(at):
            new = replace(
                channel,
                t0=channel.t0 + first * channel.ts,
                ts=k * channel.ts,
                values=channel.values[first::k],
                valid=channel.valid[first::k],
            )
            text = f"{name} changes every {k} samples alone: read at that rate"
            return new, [Finding("held", where, text, True)]
    return channel, []

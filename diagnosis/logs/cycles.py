"""Passes inside one long log: a motion that repeats within it, cut at its period.

    period = argmin_s  rms(x(t + s) - x(t)),  beyond the first s at which they differ

as a tuner finds the pitch of a tone [de Cheveigne, Kawahara 2002].
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import ceil

import numpy as np

from flexhex.diagnosis.logs.groups import ALIKE, group_runs
from flexhex.diagnosis.logs.log import COARSE, Array, Channel, Finding, Log
from flexhex.diagnosis.logs.shifts import STEPS, correlated, nearer

DIFFERS = 0.25
"""Relative mean square difference that a motion must have from itself before it comes again."""
CLOSE = 4.0
"""Times the largest difference of passes within which a coarse lag is looked at more closely."""
SHORTEST = 4.0
"""Passes are not shorter than this [s] where two of them fit: shorter cycles stay together."""


def with_cycles(logs: Sequence[Log]) -> list[Log]:
    """Logs with passes apart; as they are where some motion was run twice anyhow."""
    if not logs or any(len(group.logs) > 1 for group in group_runs(logs)):
        return list(logs)
    return [part for log in logs for part in cycles(log)]


def cycles(log: Log) -> list[Log]:
    """The passes inside a log, each a log of its own on the log's clock; the log alone if its
    motion does not repeat, or has breaks."""
    name = "r" if "r" in log.channels else "theta"
    if any(channel.breaks for channel in log.channels.values()):
        return [log]
    channel = log[name]
    period = _period(channel, ALIKE[name])
    if period is None:
        return [log]
    begin = max(c.t0 for c in log.channels.values())
    end = min(c.t0 + c.ts * len(c.values) for c in log.channels.values())
    times = int((end - begin) / period + 1e-6)
    together = min(ceil(SHORTEST / period), times // 2)
    if together < 1:
        return [log]
    length, count = together * period, times // together
    text = f"its motion repeats: {count} passes of {length:.4g} s are taken from it"
    meta = {key: value for key, value in log.meta.items() if key != "pass"}
    passes = []
    for k in range(count):
        parts = {
            own: _cut(c, begin + k * length, begin + (k + 1) * length)
            for own, c in log.channels.items()
        }
        notes = (*log.findings, Finding("cycles", log.name, text, True)) if k == 0 else ()
        piece = replace(log, name=f"{log.name}, pass {k + 1}", channels=parts)
        passes.append(replace(piece, meta=meta, findings=notes))
    return passes


def _period(channel: Channel, alike: float) -> float | None:
    """Period of a motion [s], to a fraction of a sample; None where it does not repeat."""
    values = channel.coarse
    if len(values) < 8 or not values.any():
        return None
    apart = _apart(values)
    first = int(np.argmax(apart > DIFFERS))
    if not apart[first] > DIFFERS:
        return None
    near = np.flatnonzero(apart < (CLOSE * alike) ** 2 / 2)
    near = near[near > first]
    if not len(near):
        return None
    # the first dip, down to its lowest point
    dip = near[: 1 + int(np.argmax(np.append(np.diff(near), 2) > 1))]
    period = COARSE * float(dip[np.argmin(apart[dip])])
    for _ in range(STEPS):
        step, _ = nearer(channel, channel, period)
        if step is None:
            return None
        period += step
    _, left = nearer(channel, channel, period)
    return period if left is not None and left < alike else None


def _apart(values: Array) -> Array:
    """Mean square difference of a signal (samples, n) from itself, relative to both parts' own,
    at lags up to half its length."""
    count = len(values)
    cross = correlated(values, values)[count - 1 :]
    energy = np.concatenate([[0.0], np.cumsum((values**2).sum(axis=1))])
    lags = np.arange(count // 2 + 1)
    total = energy[count - lags] + energy[count] - energy[lags]
    return np.asarray((total - 2 * cross[lags]) / np.maximum(total, 1e-300))


def _cut(channel: Channel, begin: float, end: float) -> Channel:
    a, b = (ceil((t - channel.t0) / channel.ts - 1e-6) for t in (begin, end))
    a, b = max(a, 0), min(b, len(channel.values))
    t0 = channel.t0 + a * channel.ts
    return Channel(t0, channel.ts, channel.values[a:b], channel.valid[a:b])

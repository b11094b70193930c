"""Passes inside one long log: motions that repeat within it, each cut at its period.

    period = argmin_s  rms(x(t + s) - x(t)),  beyond the first s at which they differ

as a tuner finds the pitch of a tone [de Cheveigne, Kawahara 2002].
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import ceil

import numpy as np

from flexhex.diagnosis.logs.groups import ALIKE, group_runs
from flexhex.diagnosis.logs.log import COARSE, Array, Channel, Finding, Log
from flexhex.diagnosis.logs.repeating import repeating, rests
from flexhex.diagnosis.logs.shifts import STEPS, correlated, nearer

DIFFERS = 0.25
"""Relative mean square difference that a motion must have from itself before it comes again."""
CLOSE = 4.0
"""Times the largest difference of passes within which a coarse lag is looked at more closely."""
SHORTEST = 4.0
"""Passes are not shorter than this [s] where two of them fit: shorter cycles stay together."""
REST = 0.5
"""A motion ends where all axes rest for so long [s], if it has lasted for SHORTEST. Of eight logs a
half of it parts two more, at slow turns and at rests of 0.2 s; twice as much changes none."""


@dataclass(frozen=True)
class Motion:
    """One that repeats: begin [s] on the log's clock, period [s], number of passes; first, last:
    its part of a period [s]."""

    begin: float
    period: float
    count: int
    first: float
    last: float

    def spans(self) -> list[tuple[float, float]]:
        """Begin and end of each pass [s]."""
        begins = (self.begin + k * self.period for k in range(self.count))
        return [(begin + self.first, begin + self.last) for begin in begins]


def with_cycles(logs: Sequence[Log]) -> list[Log]:
    """Logs with passes apart; as they are where some motion was run twice anyhow."""
    if not logs or any(len(group.logs) > 1 for group in group_runs(logs)):
        return list(logs)
    return [part for log in logs for part in cycles(log)]


def cycles(log: Log) -> list[Log]:
    """The passes inside a log, each a log of its own on the log's clock: of one motion, or of
    several one after the other, each of which repeats. The log alone if none does, or if it has
    breaks."""
    name = "r" if "r" in log.channels else "theta"
    if any(channel.breaks for channel in log.channels.values()):
        return [log]
    channels = log.channels.values()
    begin = max(c.t0 for c in channels)
    end = min(c.t0 + c.ts * len(c.values) for c in channels)
    found = _motions(log[name], begin, end, ALIKE[name])
    meta = {key: value for key, value in log.meta.items() if key != "pass"}
    if len(found) > 1:
        meta.pop("trajectory", None)
    notes = [Finding("cycles", log.name, text, True) for text in _texts(log, found)]
    spans = sorted(span for motion in found for span in motion.spans())
    return [
        replace(
            log,
            name=f"{log.name}, pass {k + 1}",
            channels={own: _cut(c, *span) for own, c in log.channels.items()},
            meta=meta,
            findings=(*log.findings, *notes) if k == 0 else (),
        )
        for k, span in enumerate(spans)
    ] or [log]


def _motions(channel: Channel, begin: float, end: float, alike: float) -> list[Motion]:
    """The motions that repeat between two times, in their order: of all of it, or of the longest
    part in which one does and what is beside that."""
    part = _cut(channel, begin, end)
    period = _period(part, alike)
    if period is not None:
        times = int((end - begin) / period + 1e-6)
        together = min(ceil(SHORTEST / period), times // 2)
        if not together:
            return []
        whole = Motion(begin, together * period, times // together, 0.0, together * period)
        return _apart_at_rests(part, whole)
    if (inner := repeating(part.coarse, CLOSE * alike, SHORTEST)) is None:
        return []
    first, last = (part.t0 + COARSE * k for k in inner)
    found = _motions(channel, first, last, alike) if last - first < end - begin - COARSE else []
    if not found:
        return []
    edges = ((begin, first), (max(e for m in found for _, e in m.spans()), end))
    before, after = (
        _motions(channel, *edge, alike) if edge[1] - edge[0] >= 2 * SHORTEST else []
        for edge in edges
    )
    return [*before, *found, *after]


def _apart_at_rests(channel: Channel, motion: Motion) -> list[Motion]:
    """A motion as several, where it rests in between."""
    once = _cut(channel, motion.begin, motion.begin + motion.period)
    edges = [motion.first]
    for at in [*(COARSE * k for k in rests(once.coarse, REST)), motion.last]:
        if at - edges[-1] >= SHORTEST:
            edges.append(at)
    edges[-1] = motion.last
    return [replace(motion, first=a, last=b) for a, b in pairwise(edges)]


def _texts(log: Log, found: Sequence[Motion]) -> list[str]:
    """What was taken from a log."""
    if len(found) == 1:
        (one,) = found
        return [f"its motion repeats: {one.count} passes of {one.last:.4g} s are taken from it"]
    return [
        f"from {m.begin + m.first:.4g} s on a motion of {m.last - m.first:.4g} s repeats every"
        f" {m.period:.4g} s: {m.count} passes are taken from it"
        for m in found
    ]


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

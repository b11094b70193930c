"""Whether the times of a log that jitter are those of its samples.

Two loggers make uneven times: one samples evenly and stamps what it got late, another samples
when it can and stamps that right. Late stamps stay near even times, so times that go far from them
are right. In between the values tell, as a motion is smooth: at their own times or at even ones,
wherever they change less abruptly.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from flexhex.diagnosis.logs.clock import QUIET_JITTER, Clock
from flexhex.diagnosis.logs.log import Array, Finding

SMOOTHER = 2.0
"""Values are so many times smoother at their own times where these are the samples'."""
CERTAIN = 1000.0
"""More than that is not told: of a straight line nothing is left at its own times."""
AWAY = 2.0
"""RMS distance of the times from even ones, in periods: a stamp that is late by less than a period
or two comes back to them, and beyond that the times are the samples' own. Measured: 1.1 where every
step is drawn by itself (20 s at 93 Hz), 2.7 to 11 in the parts of a Panda's log at 1 kHz."""
SAMPLE = 50_000
"""Samples of a channel that are asked."""
CLOSE = 0.5
"""Steps shorter than this many mean ones say nothing about it."""


def stamped(where: str, clock: Clock, time: Array, values: Mapping[str, Array]) -> Clock:
    """The clock of a table, with its own times where these leave any even ones or the values
    (rows, width) say that they are the samples'; a clock with breaks stays even."""
    if clock.jitter <= QUIET_JITTER or clock.breaks:
        return clock
    t = time[clock.keep]
    place = np.arange(len(t)) if clock.place is None else clock.place
    even: Array = clock.t0 + clock.ts * np.asarray(place, dtype=np.float64)
    part, away = slice(0, SAMPLE), float(np.std(t - even)) / clock.ts
    better = max(
        (
            _rougher(even[part], column, t[part])
            for channel in values.values()
            for column in channel[clock.keep][part].T
            if np.isfinite(column[part]).all() and np.ptp(column) > 0
        ),
        default=1.0,
    )
    if away <= AWAY and better < SMOOTHER:
        return clock
    if away > AWAY:
        why = f"would be {away:.2g} periods off"
    else:
        why = f"would make the motion {better:.2g} times rougher"
    text = (
        f"time jitters by {clock.jitter * clock.ts:.2g} s RMS around {clock.ts:.6g} s, and is right"
        f" (even times {why}): values taken in between"
    )
    # a long step is then the sample's own, and no sample is missing
    wrong = {"jitter", "gap"} if away > AWAY else {"jitter"}
    others = tuple(f for f in clock.findings if f.kind not in wrong)
    size = int((t[-1] - t[0]) / clock.ts + 1e-6) + 1
    findings = (*others, Finding("jitter", where, text, True))
    return replace(clock, t0=float(t[0]), place=None, size=size, stamps=t, findings=findings)


def _rougher(even: Array, x: Array, stamps: Array) -> float:
    """How many times rougher x is at even times than at its stamps, up to `CERTAIN`."""
    other, own = _roughness(even, x, stamps), _roughness(stamps, x, stamps)
    return other / max(own, other / CERTAIN) if other > 0 else 1.0


def _roughness(t: Array, x: Array, stamps: Array) -> float:
    """RMS change of the second divided differences of x, which noise and wrong times make; where
    stamps are close together noise alone would count."""
    step = np.diff(t)
    bend = np.diff(np.diff(x) / step) / (step[1:] + step[:-1])
    wide = np.diff(stamps) > CLOSE * np.diff(stamps).mean()
    changes = np.diff(bend)[wide[2:] & wide[1:-1] & wide[:-2]]
    return float(np.sqrt((changes**2).mean())) if len(changes) else 1.0

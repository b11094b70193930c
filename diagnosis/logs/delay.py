"""Delays between channels that should say the same, and whether they grow over the run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from flexhex.diagnosis.logs.log import Channel, Finding
from flexhex.diagnosis.logs.shifts import shift_of

PAIRS = {
    ("r", "theta"): (0.2, 5e-3),
    ("tau", "tau_meas"): (0.3, 2e-3),
    ("theta'", "thetad"): (0.3, 0.0),
}
"""What leads and what follows: largest relative difference; delay [s] that is normal."""
LONGEST = 30.0
"""Seconds at the start and at the end that are compared."""
SAMPLES, GROWTH = 0.6, 2.0
"""Sample periods that a delay, or its growth over the run, must exceed to be told: held signals
seem to move by a sample when their step pattern changes."""
CLOSE = 0.05
"""Step of a delay, in samples, that is no longer worth another one."""
LOOKS, STRAIGHT = 5, 0.1
"""Places along a run at which a delay is measured; part of its growth by which it may leave a
straight line where clocks differ: a feedback's lag goes with the motion."""


def delays(where: str, channels: Mapping[str, Channel]) -> list[Finding]:
    """Findings for each pair of channels that the log has; nothing is changed."""
    available = dict(channels)
    if "thetad" in channels:
        available["theta'"] = _rate(channels["theta"])
    notes: list[Finding] = []
    for (lead, follow), (alike, normal) in PAIRS.items():
        if (
            lead in available
            and follow in available
            and available[lead].width == available[follow].width
        ):
            notes += _compare(where, (lead, follow), available, alike, normal)
    return notes


def _compare(
    where: str, names: tuple[str, str], channels: Mapping[str, Channel], alike: float, normal: float
) -> list[Finding]:
    lead, follow = (channels[name] for name in names)
    if lead.breaks or follow.breaks:
        return []
    seconds = len(follow.values) * follow.ts
    length = min(LONGEST, seconds / 3)
    places = follow.t0 + np.linspace(0.0, seconds - length, LOOKS)
    lags = list[float]()
    for t in places:
        here = shift_of(_cut(lead, t, length), _cut(follow, t, length), alike, CLOSE)
        if here is None:
            return []
        lags.append(here)
    known = np.array(lags)
    first, last = float(known[0]), float(known[-1])
    period = max(lead.ts, follow.ts)
    shown = f"{names[1]} follows {names[0]}"
    bent = np.abs(known - np.linspace(first, last, LOOKS)).max()
    if abs(last - first) > max(GROWTH * period, bent / STRAIGHT):
        rate = (last - first) / (places[-1] - places[0])
        text = (
            f"{shown} by {first * 1e3:.4g} ms at the start and {last * 1e3:.4g} ms at the end:"
            f" their clocks drift by {rate * 1e6:.4g} ppm"
        )
        return [Finding("drift", where, text, False)]
    lag = float(np.median(known))
    if lag > normal + SAMPLES * period or lag < -SAMPLES * period:
        early = " (it should not come first)" if lag < 0 else ""
        return [Finding("delay", where, f"{shown} by {lag * 1e3:.4g} ms{early}", False)]
    return []


def _cut(channel: Channel, begin: float, length: float) -> Channel:
    """The samples of a channel from `begin` on for `length` [s]."""
    first = max(int(np.ceil((begin - channel.t0) / channel.ts)), 0)
    part = slice(first, first + int(length / channel.ts))
    t0 = channel.t0 + first * channel.ts
    return replace(channel, t0=t0, values=channel.values[part], valid=channel.valid[part])


def _rate(theta: Channel) -> Channel:
    rate = np.gradient(theta.values, theta.ts, axis=0)
    return replace(theta, values=rate)

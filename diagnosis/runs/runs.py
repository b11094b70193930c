"""Logs as runs: passes grouped, each with its motion on one clock."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.logs import Channel, Log, RunGroup
from flexhex.diagnosis.runs.differences import motion_of
from flexhex.diagnosis.runs.run import Run, TimeSeries
from flexhex.fmus.common.errors import LogError

Array = NDArray[np.float64]
SHARE = 0.25
"""Length, relative to the longest, below which a piece of a broken log is left out."""
FEWEST = 8
"""Samples below which a stretch between two breaks is left out."""
SKIPPED = 100
"""Runs at most that are taken to lie between two; numbers further apart are labels."""
FASTEST = 1e-3
"""Model columns are evaluated no more often than this [s]; torques keep their own rate."""
NOTHING = 1e-30
"""Angles or torques that are all smaller are no measurement, in SI units. Fits fail where squares
underflow, from 1e-154 on: the limit is far from that, and from anything measured."""
SLOWEST = 0.05
"""Longest sample time [s]. Axes under control answer within some tenths of a second, and the
shortest window takes four samples: beyond it accelerations are over before they are seen. A log of
a drive with times in ms that are taken for s has 0.06 s and more, up to 16 kHz."""


def refuse_slow(log: Log) -> None:
    """LogError where samples are too far apart to see what a controlled axis does."""
    ts = max(log["theta"].ts, log["tau_meas"].ts)
    if ts > SLOWEST:
        raise LogError(
            f"{log.name}: samples are {ts:.3g} s apart, at most {SLOWEST:g} s show how a controlled"
            f" axis accelerates: is `time` in ms (that would be {1 / (1e-3 * ts):.3g} Hz)?"
            " Correct the file, or say so with --unit 'time=ms not s'"
        )


def refuse_nothing(log: Log) -> None:
    """LogError where angles or torques are next to nothing."""
    for name in ("theta", "tau_meas"):
        largest = float(np.nanmax(np.abs(log[name].values), initial=0.0))
        if 0 < largest < NOTHING:
            unit = "is it in the unit that it should have?"
            raise LogError(f"{log.name}: {name} is nowhere larger than {largest:.3g}: {unit}")


def runs_of(
    groups: Sequence[RunGroup], n: int, starts: Mapping[str, float] | None = None
) -> list[Run]:
    """Runs of n axes; a log with breaks becomes several, each part of it a trajectory.

    starts: when each log began [s], by its name (`starts_of`); default: of these logs alone.
    Raises LogError for another number of axes.
    """
    listed = [(group.motion or group.trajectory, log) for group in groups for log in group.logs]
    began = starts_of([log for _, log in listed]) if starts is None else starts
    runs: list[Run] = []
    for trajectory in dict.fromkeys(name for name, _ in listed):
        pieces = [
            _long(_pieces(log, trajectory, n, began[log.name]))
            for name, log in listed
            if name == trajectory
        ]
        runs += _parts(trajectory, pieces)
    return runs


def of_other_motions(judged: Sequence[Run], fitted: Sequence[Run]) -> list[Run]:
    """Held-out runs that can refute what is found in the fitted ones: a pass of the same motion
    repeats whatever was taken for something else."""
    known = {run.trajectory for run in fitted}
    return [run for run in judged if run.trajectory not in known]


def _long(pieces: list[Run]) -> list[Run]:
    """Pieces of a log without those that are too short beside the others."""
    longest = max(len(run.valid) for run in pieces)
    return [run for run in pieces if len(run.valid) >= SHARE * longest]


def _parts(trajectory: str, pieces: Sequence[list[Run]]) -> list[Run]:
    """Pieces of all passes; those that lie on one another, one of each pass, are one trajectory."""
    parts: list[list[tuple[int, Run]]] = []
    for number, own in enumerate(pieces):
        for run in own:
            for part in parts:
                if all(k != number for k, _ in part) and _overlap(part[0][1], run) > 0.5:
                    part.append((number, run))
                    break
            else:
                parts.append([(number, run)])
    if len(parts) == 1:
        return [run for _, run in parts[0]]
    return [
        replace(run, trajectory=f"{trajectory}, part {k}")
        for k, part in enumerate(parts, start=1)
        for _, run in part
    ]


def _overlap(a: Run, b: Run) -> float:
    """Share of the shorter of two pieces that lies on the other, in the passes' common time."""
    starts = [run.motion.t0 - run.shift for run in (a, b)]
    seconds = [run.motion.ts * len(run.valid) for run in (a, b)]
    ends = [start + length for start, length in zip(starts, seconds, strict=True)]
    return (min(ends) - max(starts)) / min(seconds)


def _pieces(log: Log, trajectory: str, n: int, start: float) -> list[Run]:
    log.refuse_width(n)
    angles, torques = log["theta"], log["tau_meas"]
    pieces = []
    for first, end in _whole_stretches(angles):
        part = _cut(angles, first, end)
        step = max(1, round(FASTEST / part.ts))
        thin = TimeSeries(part.t0, step * part.ts, part.values[::step], part.valid[::step])
        if len(thin.values) < FEWEST:
            continue
        better = {name: c for name, c in log.channels.items() if name not in log.unused}
        measured = [better.get(name) for name in ("thetad", "thetadd")]
        pieces.append(
            Run(
                log.name,
                trajectory,
                motion_of(thin, *measured),
                _thick(thin.valid)[2:-2],
                _signal(torques, thin),
                _signal(log.channels["tau"], thin) if "tau" in log.channels else None,
                log.shift,
                start,
                payload_of(log),
                log.meta,
            )
        )
    if not pieces:
        seconds = angles.ts * len(angles.values)
        raise LogError(
            f"{log.name}: {seconds:.3g} s of angles without a break are too short: is `time` in"
            " seconds?"
        )
    return pieces


def starts_of(logs: Sequence[Log]) -> dict[str, float]:
    """When each log began [s], by its name: one after the other, by the run's number or, unless
    all have one of their own, as they were named; a run that is missing was as long as the one
    after it."""
    numbers = [number for number in map(_number, logs) if number is not None]
    if len(set(numbers)) < len(logs):
        numbers = list(range(1, len(logs) + 1))
    starts, now, following = dict[str, float](), 0.0, 1
    for number, log in sorted(zip(numbers, logs, strict=True), key=lambda pair: pair[0]):
        channel, skipped = log["theta"], max(0, number - following)
        length = channel.ts * len(channel.values)
        starts[log.name] = now + (skipped if skipped <= SKIPPED else 0) * length
        now, following = starts[log.name] + length, number + 1
    return starts


def _number(log: Log) -> int | None:
    try:
        return int(log.meta["run"])
    except (KeyError, ValueError):
        return None


def _thick(valid: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Samples whose neighbours are valid too."""
    good = valid.copy()
    for j in (1, 2):
        good[j:] &= valid[:-j]
        good[:-j] &= valid[j:]
    return good


def _whole_stretches(channel: Channel) -> list[tuple[int, int]]:
    """Index ranges without a jump of the clock."""
    edges = [0, *(index for index, _ in channel.breaks), len(channel.values)]
    return [(a, b) for a, b in pairwise(edges) if b > a]


def _cut(channel: Channel, start: int, end: int) -> TimeSeries:
    t0 = float(channel.time[start])
    return TimeSeries(t0, channel.ts, channel.values[start:end], channel.valid[start:end])


def _signal(channel: Channel, beside: TimeSeries) -> TimeSeries:
    """The stretch of a channel that lies beside angles without a jump of the clock."""
    first = beside.t0 - channel.ts
    last = beside.t0 + beside.ts * len(beside.values) + channel.ts
    best: TimeSeries | None = None
    for start, end in _whole_stretches(channel):
        part = _cut(channel, start, end)
        a = max(0, int(np.floor((first - part.t0) / part.ts)))
        b = min(len(part.values), int(np.ceil((last - part.t0) / part.ts)) + 1)
        if b > a and (best is None or b - a > len(best.values)):
            best = TimeSeries(part.t0 + a * part.ts, part.ts, part.values[a:b], part.valid[a:b])
    return best or _cut(channel, 0, len(channel.values))


def payload_of(log: Log) -> float:
    """Payload that a log tells of [kg], 0 when it does not."""
    if "payload" in log.channels:
        return float(np.median(log["payload"].values))
    try:
        return float(log.meta.get("payload", "0").removesuffix("kg"))
    except ValueError:
        return 0.0

"""Passes of one trajectory found and aligned: by what the files say, checked by the data.

Two runs are passes of one trajectory when one, moved in time, lies on the other:
    shift = argmin_s  rms(a(t) - b(t + s))       correlation first, then Gauss-Newton in s
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from flexhex.diagnosis.logs.log import COARSE, POINTS, Array, Channel, Finding, Log

ALIKE = {"r": 0.02, "theta": 0.05}
"""Largest relative difference of two passes."""
OVERLAP = 0.5
"""Part of the shorter run that must lie on the other."""
STEPS, CLOSE = 8, 1e-4
"""Most steps to the best shift, and how small the last one is, in samples."""
FEW, LIKELY = 1000, 2.0
"""Samples that tell another motion, by a difference of so many times the largest of two passes."""
NEAR = 20
"""Samples beside a coarse minimum among which the best is taken."""
OTHER_UNIT = 20.0
"""Ratio of two passes' torques that no machine makes, but another unit does."""


@dataclass(frozen=True)
class RunGroup:
    """Passes of one trajectory with one payload; each log has its `shift` [s]. findings: what
    grouping noticed. motion: the first group of this motion, by its name: groups that differ in
    payload alone share it, and its clock."""

    trajectory: str
    logs: tuple[Log, ...]
    findings: tuple[Finding, ...] = field(default=())
    motion: str = ""


def group_runs(logs: Sequence[Log]) -> list[RunGroup]:
    """Groups of passes in the order of their first log.

    The data decide, since only they can repeat: a label that contradicts them is a finding.
    Runs in which nothing moves, and other payloads, stand alone.
    """
    members: list[list[Log]] = []
    for log in logs:
        for group in members:
            shift = _shift_between(group[0], log)
            if shift is not None:
                group.append(replace(log, shift=group[0].shift + shift))
                break
        else:
            members.append([log])
    names, alike = _names(members), _motions(members)
    return [
        RunGroup(name, tuple(group), tuple(_notes(name, group, members)), names[same])
        for name, group, same in zip(names, members, alike, strict=True)
    ]


def _motions(members: list[list[Log]]) -> list[int]:
    """For each group the first one with the same motion, whatever it carries; its logs are moved
    to that one's clock."""
    motions: list[int] = []
    for k, group in enumerate(members):
        same = k
        for first in dict.fromkeys(motions):
            shift = None
            if not _same_load(members[first][0], group[0]):
                shift = _moved_between(members[first][0], group[0])
            if shift is not None:
                more = members[first][0].shift + shift - group[0].shift
                group[:] = [replace(log, shift=log.shift + more) for log in group]
                same = first
                break
        motions.append(same)
    return motions


def _names(members: list[list[Log]]) -> list[str]:
    """Labels of the groups, made unique; `trajectory 3` where no file tells one."""
    names: list[str] = []
    for k, group in enumerate(members, start=1):
        label = next((log.trajectory for log in group if log.trajectory), f"trajectory {k}")
        payload = group[0].meta.get("payload", "")
        if label in names and payload:
            label = f"{label}, payload {payload}"
        count, unique = 2, label
        while unique in names:
            unique, count = f"{label} ({count})", count + 1
        names.append(unique)
    return names


def _notes(name: str, group: list[Log], members: list[list[Log]]) -> list[Finding]:
    notes = []
    labels = sorted({log.trajectory for log in group if log.trajectory})
    where = ", ".join(log.name for log in group)
    if len(labels) > 1:
        text = f"named {' and '.join(labels)}, but they are the same motion: one trajectory"
        notes.append(Finding("metadata", where, text, True))
    if len(group) > 1 and len(labels) == 0:
        signal = "r" if "r" in group[0].channels else "theta"
        text = f"no file names its trajectory: found alike by {signal}"
        notes.append(Finding("metadata", where, text, True))
    for other in members:
        if other is group or not labels or _payload(other[0]) != _payload(group[0]):
            continue
        if other[0].trajectory in labels:
            text = f"also named {other[0].trajectory} as {other[0].name}, but another motion"
            notes.append(Finding("metadata", where, f"{text}: taken as {name!r}", True))
    sizes = [float(log.tau.std()) for log in group]
    if max(sizes) > OTHER_UNIT * min(sizes):
        least, most = (group[sizes.index(f(sizes))].name for f in (min, max))
        text = f"torques are {max(sizes) / max(min(sizes), 1e-300):.3g} times those of {least}"
        notes.append(Finding("range", most, f"{text}, of the same motion: another unit?", False))
    numbers = [log.pass_number for log in group if log.pass_number is not None]
    if len(numbers) != len(set(numbers)):
        notes.append(Finding("metadata", where, "two runs have the same pass number", True))
    if len(group) == 1:
        text = "one pass only: what does not repeat cannot be told from what the model lacks"
        notes.append(Finding("no-repeat", where, text, False))
    return notes


def _payload(log: Log) -> str:
    """Payload as far as the file tells it, for comparison: a number where it is one."""
    text = log.meta.get("payload", "").removesuffix("kg").strip()
    try:
        return f"{float(text):.6g}"
    except ValueError:
        return text


def _same_load(a: Log, b: Log) -> bool:
    if _payload(a) and _payload(b) and _payload(a) != _payload(b):
        return False
    if "payload" in a.channels and "payload" in b.channels:
        first, second = (log["payload"].values for log in (a, b))
        return bool(abs(first.mean() - second.mean()) < 1e-3 + 0.01 * abs(first).max())
    return True


def _shift_between(a: Log, b: Log) -> float | None:
    """Time [s] by which b is later than a, None when they are not passes of one trajectory."""
    if not _same_load(a, b):
        return None
    if _same_torque(a, b):
        return b["tau_meas"].t0 - a["tau_meas"].t0
    return _moved_between(a, b)


def _moved_between(a: Log, b: Log) -> float | None:
    """The same by their motion alone."""
    name = "r" if "r" in a.channels and "r" in b.channels else "theta"
    one, two = a[name], b[name]
    if one.width != two.width:
        return None
    return shift_of(one, two, ALIKE[name])


def _same_torque(a: Log, b: Log) -> bool:
    """Whether a recorded torque was played back: the same to the last digit, however it moved."""
    one, two = a["tau_meas"], b["tau_meas"]
    return bool(one.values.any()) and one.ts == two.ts and np.array_equal(one.values, two.values)


def shift_of(a: Channel, b: Channel, alike: float, close: float = CLOSE) -> float | None:
    """Shift [s] so that b(t + shift) = a(t), to a fraction of a sample; None when unlike.

    alike: largest rms(a - b) / rms(a) over the overlap; close: last step, in samples.
    """
    first, second = a.coarse, b.coarse
    if min(len(first), len(second)) < 4 or not first.any() or not second.any():
        return None
    lag = _lag(first, second)
    shift = b.t0 - a.t0 + lag * COARSE
    # a few samples tell most other motions, and all of them how late the same one is
    for points, most in ((FEW, LIKELY * alike), (POINTS, alike)):
        settled = _settled(a, b, shift, points, close)
        if settled is None or settled[1] >= most:
            return None
        shift = settled[0]
    return shift


def _settled(
    a: Channel, b: Channel, shift: float, points: int, close: float
) -> tuple[float, float] | None:
    """The best shift near this one, and the relative difference there; None without overlap."""
    for _ in range(STEPS):
        step, apart = nearer(a, b, shift, points)
        if step is None or apart is None:
            return None
        shift += step
        if abs(step) < close * min(a.ts, b.ts):
            return shift, apart
    _, apart = nearer(a, b, shift, points)
    return None if apart is None else (shift, apart)


def _lag(a: Array, b: Array) -> int:
    """Samples by which b is later than a, where they differ least over enough overlap."""
    # sum |a - b|^2 over the overlap = energy of both parts - 2 correlation
    cross = correlated(b, a)
    lags = np.arange(-len(a) + 1, len(b))
    energy_a = np.concatenate([[0.0], np.cumsum((a**2).sum(axis=1))])
    energy_b = np.concatenate([[0.0], np.cumsum((b**2).sum(axis=1))])
    begin, end = np.maximum(0, -lags), np.minimum(len(a), len(b) - lags)
    total = energy_a[end] - energy_a[begin] + energy_b[end + lags] - energy_b[begin + lags]
    enough = end - begin >= OVERLAP * min(len(a), len(b))
    apart = np.where(enough, (total - 2 * cross) / np.maximum(total, 1e-30), np.inf)
    # a motion that repeats within a run fits at several lags: the smallest of them
    equal = np.flatnonzero(apart <= apart.min() + 1e-3)
    best = equal[np.argmin(np.abs(lags[equal]))]
    near = np.abs(np.arange(len(lags)) - best) <= NEAR
    return int(lags[np.argmin(np.where(near, apart, np.inf))])


def correlated(a: Array, b: Array) -> Array:
    """Sum over columns of a[k + lag] b[k], a (samples, n), b (others, n), at lags from 1 - others
    to samples - 1."""
    size = len(a) + len(b) - 1
    count = 1 << (size - 1).bit_length()
    spectra = np.fft.rfft(a, count, axis=0) * np.fft.rfft(b, count, axis=0).conj()
    return np.roll(np.fft.irfft(spectra.sum(axis=1), count), len(b) - 1)[:size]


def _place(b: Channel, at: Array) -> Array:
    """Where instants [s] lie among the samples of a channel; beyond both ends none is inside."""
    if not b.breaks:
        return (at - b.t0) / b.ts
    return np.interp(at, b.time, np.arange(len(b.values)))


def nearer(
    a: Channel, b: Channel, shift: float, points: int = POINTS
) -> tuple[float | None, float | None]:
    """Step towards the best shift, and the relative difference at this one, by about so many
    points."""
    every = slice(None, None, max(1, len(a.values) // points))
    place = _place(b, a.time[every] + shift)
    inside = a.valid[every] & (place >= 1) & (place <= len(b.values) - 2)
    # one place between two samples serves all columns, a sample before and after it, too
    first = np.clip(place.astype(int), 1, len(b.values) - 3)
    trusted = b.valid[first] & b.valid[first + 1]
    kept = np.flatnonzero(inside & trusted)
    if len(kept) < 8:
        return None, None
    place, first, wanted = place[kept], first[kept], a.values[every][kept]
    share = (place - first)[:, None]
    values = [b.values.take(first + k, axis=0) for k in (-1, 0, 1, 2)]
    before, moved, after = (one + share * (two - one) for one, two in pairwise(values))
    slope, apart = (after - before) / (2 * b.ts), wanted - moved
    if not (slope**2).sum() > 0:
        return None, None
    # an offset between passes is no difference of motion
    apart = apart - apart.mean(axis=0)
    size = float(np.sqrt(((wanted - wanted.mean(axis=0)) ** 2).mean()))
    step = float((slope * apart).sum() / (slope**2).sum())
    limit = 2 * COARSE
    return max(-limit, min(limit, step)), float(np.sqrt((apart**2).mean())) / max(size, 1e-30)

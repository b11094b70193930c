"""Passes of one trajectory found and aligned: by what the files say, checked by the data.

Two runs are passes of one trajectory when one, moved in time, lies on the other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from flexhex.diagnosis.logs.log import Finding, Log
from flexhex.diagnosis.logs.passes import contradictions
from flexhex.diagnosis.logs.shifts import nearer, shift_of

ALIKE = {"r": 0.02, "theta": 0.05}
"""Largest relative difference of two passes."""
SAME_TORQUE = 0.3
"""The same of their torques, from which a held-out run is no pass: it was pushed otherwise. Passes
of simulated machines differ by 0.21 at most, a linear axis (EMPS) with pulses and without by 0.40.
"""


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


def held_out(groups: Sequence[RunGroup], apart: Sequence[RunGroup]) -> list[RunGroup]:
    """Held-out groups beside the fitted ones: with the motion of a fitted one that they repeat, and
    a finding; others with a name that no fitted one has."""
    fitted = {group.motion: group.logs[0] for group in reversed(groups)}
    named = []
    for group in apart:
        own = group.logs[0]
        motion = next((motion for motion, log in fitted.items() if _repeats(log, own)), "")
        findings = group.findings
        if motion:
            text = (
                f"held out, but the same motion as {fitted[motion].name}: it cannot refute what is"
                " found there, hold out another motion"
            )
            where = ", ".join(log.name for log in group.logs)
            findings = (*findings, Finding("held-out", where, text, False))
        else:
            motion = f"{group.motion}, held out" if group.motion in fitted else group.motion
        named.append(replace(group, motion=motion, findings=findings))
    return named


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
        text = f"no file names its trajectory: runs with the same {signal} are taken for one"
        notes.append(Finding("metadata", where, text, True))
    for other in members:
        if other is group or not labels or _payload(other[0]) != _payload(group[0]):
            continue
        if other[0].trajectory in labels:
            text = f"also named {other[0].trajectory} as {other[0].name}, but another motion"
            notes.append(Finding("metadata", where, f"{text}: taken as {name!r}", True))
    notes += contradictions(group, [log for logs in members for log in logs])
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


def _repeats(a: Log, b: Log) -> bool:
    """Whether motion and torque of b are those of a: nothing in it is new."""
    shift = _moved_between(a, b)
    if shift is None:
        return False
    apart = nearer(a["tau_meas"], b["tau_meas"], shift)[1]
    return apart is not None and apart < SAME_TORQUE


def _same_torque(a: Log, b: Log) -> bool:
    """Whether a recorded torque was played back: the same to the last digit, however it moved."""
    one, two = a["tau_meas"], b["tau_meas"]
    return bool(one.values.any()) and one.ts == two.ts and np.array_equal(one.values, two.values)

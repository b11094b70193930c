"""What a recording of the gateway tells: errors, times of a cycle, what was missed, states."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flexhex.fmus.common.errors import LogError
from flexhex.recording import RUNNING, Recording
from flexhex.tracking import SETTLE

Array = NDArray[np.float64]
MICRO = 1e6
PARTS = {"wake_up": "wake-up", "round_trip": "round trip of the frame", "compute": "computing"}
"""Channels of the times of a cycle [µs], and what they are called."""
NEEDED = (
    *("theta", "tau_meas", "e", "statusword", "al_state", "error_code"),
    *("answered", "working_counter", "late_threads", *PARTS),
)
"""Channels that a report is made of."""
MOST_CHANGES = 40
DRIVE = {
    0x00: (0x4F, "not ready to switch on"),
    0x40: (0x4F, "switch on disabled"),
    0x21: (0x6F, "ready to switch on"),
    0x23: (0x6F, "switched on"),
    0x27: (0x6F, "operation enabled"),
    0x07: (0x6F, "quick stop active"),
    0x0F: (0x4F, "fault reaction active"),
    0x08: (0x4F, "fault"),
}
"""States of CiA 402: bits of the statusword, the mask that they are seen through, the name."""
LAYER = {1: "INIT", 2: "PRE-OP", 3: "BOOT", 4: "SAFE-OP", 8: "OP"}


@dataclass(frozen=True)
class Missed:
    """Cycles without a sample: left out by the clock, without a reply, with a short counter."""

    left_out: int
    unanswered: int
    short: int
    late_threads: int


def require(recording: Recording, name: str) -> None:
    """LogError for a recording, called `name`, without a channel that a report is made of."""
    there = {column.partition("[")[0] for column in recording.names}
    if lacking := [channel for channel in NEEDED if channel not in there]:
        raise LogError(
            f"{name}: a recording without {', '.join(lacking)}: record the run again with"
            " `flexhex-gateway run --record`, or look at it with `flexhex view`"
        )


def seconds(recording: Recording) -> Array:
    """Time of each row [s]."""
    return recording["time"]


def running(recording: Recording) -> NDArray[np.bool_]:
    """Rows of cycles in which the controller ran."""
    return np.equal(recording["phase"], RUNNING)


def missed(recording: Recording) -> Missed:
    """What there is no sample of."""
    rows = running(recording)
    steps = np.rint(seconds(recording)[rows] / recording.base)
    answered, counter = recording["answered"][rows] == 1, recording["working_counter"][rows]
    complete = counter.max(initial=0.0)
    return Missed(
        int(np.sum(np.diff(steps) - 1)),
        int(np.sum(~answered)),
        int(np.sum(answered & (counter < complete))),
        int(recording["late_threads"].max(initial=0.0)),
    )


def errors(recording: Recording) -> list[tuple[float, float, float]]:
    """RMS and largest tracking error of each axis [µrad] and when it was [s].

    Judged from the settling time on; a recording that ends before is judged as a whole.
    """
    time, rows = seconds(recording), running(recording)
    late = rows & (time > SETTLE)
    kept = late if late.any() else rows
    e, at = MICRO * recording["e"][kept], time[kept]
    return [
        (float(np.sqrt(np.mean(column**2))), float(most), float(at[np.abs(column).argmax()]))
        for column, most in zip(e.T, np.abs(e).max(axis=0), strict=True)
    ]


def quantiles(recording: Recording) -> dict[str, tuple[float, ...]]:
    """p50, p99, p99.9 and the largest of each part of a cycle [µs]; lost replies have no round."""
    rows = running(recording)
    answered = rows & (recording["answered"] == 1)
    parts = {name: recording[name][answered if name == "round_trip" else rows] for name in PARTS}
    return {
        name: (*(float(q) for q in np.percentile(values, (50, 99, 99.9))), float(values.max()))
        for name, values in parts.items()
        if values.size
    }


def slower(values: Array) -> tuple[Array, Array]:
    """Times [µs] in rising order and the share of cycles that took at least so long."""
    ordered = np.sort(values[values > 0])
    return ordered, 1.0 - np.arange(len(ordered)) / max(len(ordered), 1)


def drive_state(word: float) -> str:
    """State of CiA 402 in a statusword."""
    bits = int(word)
    for wanted, (mask, name) in DRIVE.items():
        if bits & mask == wanted:
            return name
    return f"statusword {bits:#06x}"


def layer_state(status: float) -> str:
    """EtherCAT state in an AL status; 0: the device did not answer."""
    code = int(status) & 0x0F
    return LAYER.get(code, f"AL status {int(status):#04x}") if status else "no answer"


def changes(recording: Recording) -> list[tuple[float, str, str]]:
    """Time [s], axes and the new state of whatever changed; the first rows are how it began."""
    kinds = (("statusword", drive_state), ("al_state", layer_state), ("error_code", fault))
    listed = [
        (float(seconds(recording)[row]), f"{axis}", text)
        for channel, name in kinds
        for axis, column in enumerate(recording[channel].T, start=1)
        for row, text in _altered(column, name)
    ]
    return _together(sorted(listed))


def fault(code: float) -> str:
    """An error code of a drive; 0 is none."""
    return f"fault {int(code):#06x}" if code else "no fault"


def _altered(values: Array, name: Callable[[float], str]) -> list[tuple[int, str]]:
    """Rows from which a state has another name; bits that name nothing may change meanwhile."""
    rows = np.flatnonzero(np.r_[True, np.diff(values) != 0])
    named = [(int(row), name(float(values[row]))) for row in rows]
    before = ["", *(text for _, text in named[:-1])]
    return [(row, text) for (row, text), last in zip(named, before, strict=True) if text != last]


def _together(listed: Sequence[tuple[float, str, str]]) -> list[tuple[float, str, str]]:
    """Axes that do the same at the same time in one row."""
    rows: dict[tuple[float, str], list[str]] = {}
    for time, axis, text in listed:
        rows.setdefault((time, text), []).append(axis)
    return [(time, _axes(axes), text) for (time, text), axes in rows.items()][:MOST_CHANGES]


def _axes(axes: Sequence[str]) -> str:
    return "all" if len(axes) == 6 else ", ".join(axes)

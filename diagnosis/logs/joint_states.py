"""JointState messages of one topic of a ROS 2 bag as a log.

Positions are `theta`, velocities `thetad`, efforts `tau_meas`, in SI units as ROS has them; time is
that of the header, or of the log where headers have none.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from flexhex.diagnosis.logs.extras import as_tables
from flexhex.diagnosis.logs.log import Finding, Options
from flexhex.diagnosis.logs.raw import Raw
from flexhex.fmus.common.errors import LogError

TYPES = ("sensor_msgs/msg/JointState", "sensor_msgs/JointState")
CHANNELS = {"theta": "position", "thetad": "velocity", "tau_meas": "effort"}
UNITS = {"time": "s", "theta": "rad", "thetad": "rad/s", "tau_meas": "N m"}
Messages = Mapping[str, list[tuple[int, Any]]]
"""Messages with log times [ns], by topic."""


def raw_of(path: Path, options: Options, messages: Messages, others: Collection[str]) -> Raw:
    """The messages of the only topic that has any; others: all topics of the bag. LogError tells
    what it has instead."""
    if not messages:
        shown = ", ".join(sorted(others)) or "nothing"
        raise LogError(
            f"{path}: JointState messages on no topic: it has {shown}; record that of the joints,"
            " often /joint_states"
        )
    if len(messages) > 1:
        raise LogError(
            f"{path}: JointState messages on several topics: {', '.join(sorted(messages))}; write"
            " those of one robot into a bag of their own (`ros2 bag convert`)"
        )
    ((topic, listed),) = messages.items()
    count: Counter[tuple[str, ...]] = Counter(tuple(sorted(m.name)) for _, m in listed)
    joints, _ = count.most_common(1)[0]
    kept = [(at, m) for at, m in listed if tuple(sorted(m.name)) == joints]
    names = list(kept[0][1].name)
    data: dict[str, Any] = {"time": _times(kept)}
    for channel, field in CHANNELS.items():
        values = [_ordered(message, field, names) for _, message in kept]
        if all(len(row) == len(names) for row in values):
            data[channel] = np.array(values, dtype=np.float64)
    if not names or "theta" not in data or "tau_meas" not in data:
        raise LogError(
            f"{path}: {topic} has no {'position' if 'theta' not in data else 'effort'} of its"
            " joints: record a topic that has both"
        )
    units = dict(UNITS)
    meta = {"joints": ",".join(names)}
    raw = as_tables(path, [(topic, data)], units, meta, options, list(data))
    for table in raw.tables:
        # joints that slide have others
        table.stated = False
    text = (
        f"axes are the joints {meta['joints']}, efforts are taken for N m (of currents say --unit"
        " tau_meas=A with --torque-constant)"
    )
    raw.findings.append(Finding("names", f"{path}: {topic}", text, True))
    if len(count) > 1:
        text = f"{len(listed) - len(kept)} messages of other joints are left out"
        raw.findings.append(Finding("extra", f"{path}: {topic}", text, True))
    return raw


def _times(listed: list[tuple[int, Any]]) -> Any:
    """Seconds since the first message."""
    stamps = [10**9 * m.header.stamp.sec + m.header.stamp.nanosec for _, m in listed]
    at = stamps if any(stamps) else [logged for logged, _ in listed]
    return np.array([1e-9 * (t - at[0]) for t in at])


def _ordered(message: Any, field: str, names: list[str]) -> list[float]:
    values = list(getattr(message, field))
    if len(values) != len(names):
        return []
    own = dict(zip(message.name, values, strict=True))
    return [own[name] for name in names]

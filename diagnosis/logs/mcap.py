"""MCAP: the JointState messages of one topic of a ROS 2 bag as a log, and results of ours.

Positions are `theta`, velocities `thetad`, efforts `tau_meas`, in SI units as ROS has them; time is
that of the header, or of the log where headers have none.
"""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from flexhex.diagnosis.logs.extras import as_tables, installed
from flexhex.diagnosis.logs.hdf5 import OURS
from flexhex.diagnosis.logs.log import Finding, Options
from flexhex.diagnosis.logs.raw import CHANNELS as KNOWN
from flexhex.diagnosis.logs.raw import Raw
from flexhex.fmus.common.errors import LogError
from flexhex.ssp.formats.mcap import is_result, read

JOINT_STATE = ("sensor_msgs/msg/JointState", "sensor_msgs/JointState")
CHANNELS = {"theta": "position", "thetad": "velocity", "tau_meas": "effort"}
UNITS = {"time": "s", "theta": "rad", "thetad": "rad/s", "tau_meas": "N m"}


def read_mcap(path: Path, options: Options) -> Raw:
    """Read a bag; LogError tells what it has instead of the JointState messages of one topic."""
    installed(path, "mcap.reader", "ros")
    if is_result(path):
        return _of_result(path, options)
    messages, others = _messages(path)
    if len(messages) != 1:
        shown = ", ".join(sorted(messages) or sorted(others)) or "nothing"
        what = "on several topics" if messages else "on no topic"
        raise LogError(
            f"{path}: JointState messages {what}: it has {shown}; write those of one robot into a"
            " bag of their own (`ros2 bag convert`)"
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
    text = f"axes are the joints {meta['joints']} (--joints takes them so), in rad and N m"
    raw.findings.append(Finding("names", f"{path}: {topic}", text, True))
    if len(count) > 1:
        text = f"{len(listed) - len(kept)} messages of other joints are left out"
        raw.findings.append(Finding("extra", f"{path}: {topic}", text, True))
    return raw


def _of_result(path: Path, options: Options) -> Raw:
    """A result of `flexhex convert`: its groups as tables."""
    result = read(path)
    groups, units, names = [], {"time": "s"}, list[str]()
    for rate, group in result.groups.items():
        known = {c: signal for c, signal in OURS.items() if signal in group.signals}
        known |= {name: name for name in group.signals if name in KNOWN}
        data = {channel: group.signals[signal] for channel, signal in known.items()}
        units |= {channel: group.units.get(signal, "") for channel, signal in known.items()}
        names += group.signals
        groups.append((rate, {"time": group.time, **data}))
    meta = {key: str(value) for key, value in result.meta.items()}
    return as_tables(path, groups, units, meta, options, names)


def _messages(path: Path) -> tuple[dict[str, list[tuple[int, Any]]], set[str]]:
    """JointState messages with log times [ns], by topic; and the other topics."""
    reader = installed(path, "mcap.reader", "ros")
    decoder = installed(path, "mcap_ros2.decoder", "ros")
    messages: dict[str, list[tuple[int, Any]]] = {}
    others: set[str] = set()
    try:
        with path.open("rb") as file:
            bag = reader.make_reader(file, decoder_factories=[decoder.DecoderFactory()])
            summary = bag.get_summary()
            topics = [
                channel.topic
                for channel in (summary.channels.values() if summary else ())
                if summary.schemas[channel.schema_id].name in JOINT_STATE
            ]
            others = {c.topic for c in (summary.channels.values() if summary else ())}
            if topics:
                for _, channel, message, decoded in bag.iter_decoded_messages(topics=topics):
                    messages.setdefault(channel.topic, []).append((message.log_time, decoded))
    except OSError:
        raise
    except Exception as error:  # mcap's own classes
        raise LogError(f"{path}: not a readable MCAP file ({error})") from None
    return messages, others


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

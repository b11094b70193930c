"""MCAP: a ROS 2 bag, or a result of ours."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from flexhex.diagnosis.logs.extras import as_tables, installed
from flexhex.diagnosis.logs.hdf5 import OURS
from flexhex.diagnosis.logs.joint_states import TYPES, raw_of
from flexhex.diagnosis.logs.log import Options
from flexhex.diagnosis.logs.raw import CHANNELS as KNOWN
from flexhex.diagnosis.logs.raw import Raw
from flexhex.fmus.common.errors import LogError
from flexhex.ssp.formats.mcap import is_result, read


def read_mcap(path: Path, options: Options) -> Raw:
    """Read a bag, or a result of `flexhex convert`."""
    installed(path, "mcap.reader", "ros")
    if is_result(path):
        return _of_result(path, options)
    return raw_of(path, options, *_messages(path))


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
                if summary.schemas[channel.schema_id].name in TYPES
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

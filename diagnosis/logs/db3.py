"""A ROS 2 bag in SQLite (`.db3`, the storage of ROS 2 before Iron)."""

from __future__ import annotations

import sqlite3
from pathlib import Path
from typing import Any

from flexhex.diagnosis.logs.extras import installed
from flexhex.diagnosis.logs.joint_states import TYPES, raw_of
from flexhex.diagnosis.logs.log import Options
from flexhex.diagnosis.logs.raw import Raw
from flexhex.fmus.common.errors import LogError

JOINT_STATE = b"""std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
===
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
===
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""
"""Fields of a message, which older bags do not tell [ROS 2, sensor_msgs/msg/JointState]."""

ZSTD = b"\x28\xb5\x2f\xfd"
"""What compressed data begin with [RFC 8878, 3.1.1]."""
UNPACK = "`ros2 bag convert` with `compression_mode: none` writes them as they are"


def read_db3(path: Path, options: Options) -> Raw:
    """Read a bag; LogError tells what it has instead of the JointState messages of one topic."""
    factory = installed(path, "mcap_ros2.decoder", "ros").DecoderFactory()
    schema = installed(path, "mcap.records", "ros").Schema
    decode = factory.decoder_for("cdr", schema(1, JOINT_STATE, "ros2msg", TYPES[0]))
    messages: dict[str, list[tuple[int, Any]]] = {}
    try:
        bag = sqlite3.connect(f"{path.resolve().as_uri()}?mode=ro", uri=True)
        try:
            topics = bag.execute("SELECT id, name, type FROM topics ORDER BY name").fetchall()
            joints = {number: name for number, name, kind in topics if kind in TYPES}
            # pictures and scans of other topics may be gigabytes
            some = f"topic_id IN ({','.join('?' * len(joints))})"
            wanted = f"SELECT topic_id, timestamp, data FROM messages WHERE {some}"
            for number, at, data in bag.execute(f"{wanted} ORDER BY timestamp", [*joints]):
                if data.startswith(ZSTD):
                    raise LogError(f"{path}: its messages are compressed: {UNPACK}")
                messages.setdefault(joints[number], []).append((at, decode(data)))
        finally:
            bag.close()
    except LogError:
        raise
    except Exception as error:  # those of SQLite and of the decoder
        raise LogError(
            f"{path}: not a readable bag of ROS 2 ({error}): copy or record it again, or `sqlite3"
            f" {path.name} .recover`"
        ) from None
    return raw_of(path, options, messages, {name for _, name, _ in topics})

"""ROS 2 bags in SQLite: messages in CDR, encoded here by hand [OMG DDSI-RTPS 2.5, 10]."""

from __future__ import annotations

import sqlite3
import struct
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from flexhex.diagnosis.logs import read_log
from flexhex.fmus.common.errors import LogError
from tests.compare import assert_close

pytest.importorskip("mcap_ros2.decoder", reason="the extra `ros` is not installed")
NAMES = ("elbow", "base")
T = np.arange(300) * 0.002
Q = np.sin(np.outer(T, (1.0, 2.0)))
TAU = np.cos(np.outer(T, (5.0, 3.0)))


def encoded(at: int, names: Sequence[str], *fields: Sequence[float]) -> bytes:
    """A JointState in little-endian CDR: each number at a multiple of its size."""
    body = struct.pack("<iI", at // 10**9, at % 10**9)

    def padded(size: int) -> None:
        nonlocal body
        body += bytes(-len(body) % size)

    def text(value: str) -> None:
        nonlocal body
        padded(4)
        body += struct.pack("<I", len(value) + 1) + value.encode() + b"\0"

    text("")
    padded(4)
    body += struct.pack("<I", len(names))
    for name in names:
        text(name)
    for values in fields:
        padded(4)
        body += struct.pack("<I", len(values))
        if values:
            padded(8)
            body += struct.pack(f"<{len(values)}d", *values)
    return b"\0\1\0\0" + body


def bag(
    path: Path, topics: Sequence[tuple[str, str]], messages: Sequence[bytes], publishers: int = 1
) -> Path:
    """A bag of topics (name, type) with these messages on the first one, or by turns on the first
    few."""
    with sqlite3.connect(path) as file:
        file.execute(
            "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT,"
            " serialization_format TEXT, offered_qos_profiles TEXT)"
        )
        file.execute(
            "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER,"
            " data BLOB)"
        )
        for k, (name, kind) in enumerate(topics, start=1):
            file.execute("INSERT INTO topics VALUES(?, ?, ?, 'cdr', '')", (k, name, kind))
        rows = [
            (k % publishers + 1, 7_000_000 + 2_000_000 * k, data) for k, data in enumerate(messages)
        ]
        file.executemany("INSERT INTO messages(topic_id, timestamp, data) VALUES(?, ?, ?)", rows)
    file.close()
    return path


def messages(stamped: bool = True, effort: bool = True) -> list[bytes]:
    start = 1_700_000_000_000_000_000
    at = [start + 2_000_000 * k if stamped else 0 for k in range(len(T))]
    efforts = TAU.tolist() if effort else [[]] * len(T)
    return [
        encoded(t, NAMES, q.tolist(), (3 * q).tolist(), tau)
        for t, q, tau in zip(at, Q, efforts, strict=True)
    ]


JOINTS = ("/joint_states", "sensor_msgs/msg/JointState")
STATES = [JOINTS, ("/tf", "tf2_msgs/msg/TFMessage")]


@pytest.mark.parametrize("stamped", [True, False], ids=["header's time", "log's time"])
def test_joint_states_are_read(stamped: bool, tmp_path: Path) -> None:
    log = read_log(bag(tmp_path / "run 1?.db3", STATES, messages(stamped)))
    assert_close(log.theta, Q, atol=1e-12)
    assert_close(log["thetad"].values, 3 * Q, atol=1e-12)
    assert_close(log.tau, TAU, atol=1e-12)
    assert_close(log.ts, 0.002, rtol=1e-6)
    assert log.joints == NAMES


def test_messages_of_a_topic_with_two_numbers_are_one_log(tmp_path: Path) -> None:
    log = read_log(bag(tmp_path / "run.db3", [JOINTS, JOINTS], messages(), publishers=2))
    assert_close(log.theta, Q, atol=1e-12)


def test_folder_of_a_bag_is_refused_with_the_log_in_it(tmp_path: Path) -> None:
    (tmp_path / "metadata.yaml").touch()
    bag(tmp_path / "run_0.db3", STATES, messages())
    with pytest.raises(LogError, match=r"is a folder: name a file in it, .*/run_0\.db3$"):
        read_log(tmp_path)


def test_what_is_no_log_is_refused(tmp_path: Path) -> None:
    others = [("/scan", "sensor_msgs/msg/LaserScan")]
    with pytest.raises(LogError, match=r"on no topic: it has /scan"):
        read_log(bag(tmp_path / "scan.db3", others, messages()))
    with pytest.raises(LogError, match=r"on no topic: it has /joint_states, /tf"):
        read_log(bag(tmp_path / "empty.db3", STATES, []))
    with pytest.raises(LogError, match=r"/joint_states has no effort of its joints"):
        read_log(bag(tmp_path / "none.db3", STATES, messages(effort=False)))
    packed = [b"\x28\xb5\x2f\xfd" + one for one in messages()]
    with pytest.raises(LogError, match=r"its messages are compressed: `ros2 bag convert`"):
        read_log(bag(tmp_path / "packed.db3", STATES, packed))
    (tmp_path / "bad.db3").write_bytes(b"no bag")
    with pytest.raises(LogError, match=r"not a readable bag of ROS 2 \(file is not a database\)"):
        read_log(tmp_path / "bad.db3")
    with pytest.raises(LogError, match=r"not a readable bag of ROS 2"):
        read_log(bag(tmp_path / "cut.db3", STATES, [one[:40] for one in messages()]))

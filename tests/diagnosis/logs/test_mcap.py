"""ROS 2 bags in MCAP, written by the library that ROS users have."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.kinds import LINEAR
from flexhex.diagnosis.logs import Options, read_log, refuse_other_joints
from flexhex.fmus.common.errors import LogError
from tests.compare import assert_close

ros = pytest.importorskip("mcap_ros2.writer", reason="the extra `ros` is not installed")
Array = NDArray[np.float64]
JOINT_STATE = """std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""
T = np.arange(500) * 0.002
Q = np.sin(np.outer(T, (1.0, 2.0)))
TAU = np.cos(np.outer(T, (5.0, 3.0)))
NAMES = ["elbow", "base"]


def message(k: int, names: list[str], stamped: bool = True, **changed: Any) -> dict[str, Any]:
    order = [NAMES.index(name) for name in names]
    at = 1_700_000_000_000_000_000 + 2_000_000 * k if stamped else 0
    return {
        "header": {"stamp": {"sec": at // 10**9, "nanosec": at % 10**9}, "frame_id": ""},
        "name": names,
        "position": Q[k, order].tolist(),
        "velocity": (3 * Q[k, order]).tolist(),
        "effort": TAU[k, order].tolist(),
    } | changed


def bag(path: Path, messages: list[dict[str, Any]], *topics: str) -> Path:
    """A bag with the same messages on each topic, logged 2 ms apart."""
    with path.open("wb") as file:
        writer = ros.Writer(file)
        schema = writer.register_msgdef("sensor_msgs/msg/JointState", JOINT_STATE)
        for topic in topics or ("/joint_states",):
            for k, one in enumerate(messages):
                writer.write_message(topic, schema, one, log_time=5_000_000 + 2_000_000 * k)
        writer.finish()
    return path


@pytest.mark.parametrize("stamped", [True, False], ids=["header's time", "log's time"])
def test_joint_states_are_read_by_their_names(stamped: bool, tmp_path: Path) -> None:
    # a publisher may list its joints in any order
    listed = [message(k, NAMES if k % 3 else NAMES[::-1], stamped) for k in range(len(T))]
    listed[0] = message(0, NAMES, stamped)
    log = read_log(bag(tmp_path / "run.mcap", listed))
    assert_close(log.theta, Q, atol=1e-12)
    assert_close(log.tau, TAU, atol=1e-12)
    assert_close(log["thetad"].values, 3 * Q, atol=1e-12)
    assert_close(log.ts, 0.002, rtol=1e-6)
    assert any("the joints elbow,base" in str(finding) for finding in log.findings)
    assert log.joints == ("elbow", "base")


def test_bags_with_joints_in_another_order_are_refused(tmp_path: Path) -> None:
    logs = [
        read_log(bag(tmp_path / f"{names[0]}.mcap", [message(k, names) for k in range(len(T))]))
        for names in (NAMES, NAMES[::-1])
    ]
    refuse_other_joints(logs[:1] * 2)
    with pytest.raises(LogError, match=r"base.mcap: its joints are base, elbow; those of .*elbow"):
        refuse_other_joints(logs)


def test_units_of_joints_that_slide_are_given_once(tmp_path: Path) -> None:
    path = bag(tmp_path / "run.mcap", [message(k, NAMES) for k in range(len(T))])
    units = {"theta": "rad,m", "thetad": "rad/s,m/s", "tau_meas": "N m,N"}
    assert read_log(path, Options(units=units)).kinds[1] is LINEAR


def test_messages_of_other_joints_are_left_out(tmp_path: Path) -> None:
    listed = [message(k, NAMES) for k in range(len(T))]
    gripper = {"name": ["finger"], "position": [0.1], "velocity": [0.0], "effort": [0.0]}
    listed[7:7] = [message(7, NAMES, **gripper)]
    log = read_log(bag(tmp_path / "run.mcap", listed))
    assert_close(log.theta, Q, atol=1e-12)
    assert any("1 messages of other joints" in str(finding) for finding in log.findings)


def test_missing_extra_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = bag(tmp_path / "run.mcap", [message(0, NAMES)])
    monkeypatch.setitem(sys.modules, "mcap.reader", None)
    with pytest.raises(LogError, match=r"needs the package mcap: pip install 'flexhex\[ros\]'"):
        read_log(path)


def test_what_is_no_log_is_refused(tmp_path: Path) -> None:
    listed = [message(k, NAMES) for k in range(20)]
    with pytest.raises(LogError, match=r"on several topics: /a, /b"):
        read_log(bag(tmp_path / "two.mcap", listed, "/a", "/b"))
    none = [message(k, NAMES, effort=[]) for k in range(20)]
    with pytest.raises(LogError, match="/joint_states has no effort of its joints"):
        read_log(bag(tmp_path / "none.mcap", none))
    with pytest.raises(LogError, match=r"on no topic: it has nothing"):
        read_log(bag(tmp_path / "empty.mcap", []))
    (tmp_path / "bad.mcap").write_bytes(b"no bag")
    with pytest.raises(LogError, match="not a readable MCAP file"):
        read_log(tmp_path / "bad.mcap")

"""The emulated drives against an independent master (SOEM) and an independent decoder (tshark)."""

from __future__ import annotations

import importlib.util
import json
import shutil
import struct
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from tests.gateway.alone import paused
from tests.gateway.bench import columns
from tests.gateway.cable import Cable, cable
from tests.gateway.cargo import built
from tests.gateway.decoder import capturing, decode, malformed, need_tshark
from tests.gateway.pysoem_session import STALL_S, target

SESSION = Path(__file__).with_name("pysoem_session.py")
CYCLES = 4000
LIMIT_S = 60
"""A session that hangs is ended after this; nothing is measured with it."""
DT = 0.00025
TORQUE_STEP = {"akd": 3.0 * 0.001, "cst": 9000.0 * 0.001 * 0.001}
ANGLE_STEP = 2.0 * np.pi / 2.0**32
INERTIA, FRICTION = 0.05, 0.2
Table = npt.NDArray[np.float64]


def need_pysoem() -> None:
    """Skips without the independent master."""
    if importlib.util.find_spec("pysoem") is None:
        pytest.skip("no pysoem: pip install pysoem")


@contextmanager
def drives(
    ends: Cable, folder: Path, kind: str, options: str = "", lockstep: bool = True
) -> Iterator[tuple[list[Any], int]]:
    """Events of emulated drives, all there when the block has ended, and their process."""
    program = built() / "flexhex-emulator"
    file = folder / "drives.toml"
    file.write_text(options)
    words = [program, "--interface", "bus0", "--json", "--drives", kind]
    words += ["--lockstep"] * lockstep
    words += ["--options", file, "--log", folder / "drives.csv"]
    process = subprocess.Popen(ends.at(ends.drives, words), stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    events: list[Any] = [json.loads(process.stdout.readline())]
    assert events[0]["event"] == "ready"
    try:
        yield events, process.pid
    finally:
        process.terminate()
        events += map(json.loads, process.communicate(timeout=LIMIT_S)[0].splitlines())
    assert process.returncode == 0


def session(ends: Cable, kind: str, *words: object, cycles: int = CYCLES) -> dict[str, Any]:
    """Observations of the independent master."""
    command = ends.at(ends.gateway, [sys.executable, SESSION, "bus1", kind, cycles, *words])
    done = subprocess.run(command, capture_output=True, text=True, timeout=LIMIT_S)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout) if done.stdout else {}


def flywheels(kind: str) -> tuple[Table, Table]:
    """Counts (n, 6) and measured steps (n, 6) of the flywheels, computed independently."""
    theta, speed = np.zeros(6), np.zeros(6)
    counts, steps = np.zeros((CYCLES, 6)), np.zeros((CYCLES, 6))
    for n in range(CYCLES):
        wanted = np.array([target(n, axis) for axis in range(6)], dtype=float)
        counts[n] = np.rint(theta / ANGLE_STEP)
        if n + 1 < CYCLES:
            steps[n + 1] = wanted
        speed = speed + DT * (wanted * TORQUE_STEP[kind] - FRICTION * speed) / INERTIA
        theta = theta + DT * speed
    return counts, steps


@pytest.mark.parametrize("kind", ["akd", pytest.param("cst", marks=pytest.mark.slow)])
def test_an_independent_master_reaches_op_and_moves_the_drives(kind: str, tmp_path: Path) -> None:
    need_pysoem()
    with cable() as ends, drives(ends, tmp_path, kind) as (events, _):
        seen = session(ends, kind)
    vendor, product = {"akd": (0x6A, 0x414B44), "cst": (0xF1E, 0x4020010)}[kind]
    assert seen["found"] == 6
    assert [one[1:3] for one in seen["identity"]] == [[vendor, product]] * 6
    assert seen["serial"] == [1000, 1001, 1002, 1003, 1004, 1005]
    assert seen["name"] == seen["identity"][0][0], "the EEPROM and the object dictionary agree"
    assert (seen["safe_op"], seen["op"]) == (4, 8)
    assert seen["image_bytes"] == 6 * {"akd": 8 + 16, "cst": 6 + 12}[kind]
    assert seen["aborts"] == {
        "unknown": 0x06020000,
        "read only": 0x06010002,
        "map in SAFE-OP": 0x08000022,
    }
    assert seen["counters"] == [seen["expected_counter"]] == [18], "no frame was short"
    # one nanosecond of rounding, and the step of the control loop
    assert seen["clocks"]
    assert max(seen["clock_ns"]) <= 20, seen["clock_ns"]
    rows = np.array(seen["rows"], dtype=float)
    counts, steps = flywheels(kind)
    # the same sums in the same order: to the last bit, and so is their rounding
    np.testing.assert_array_equal(rows[:, :, 0], counts)
    np.testing.assert_array_equal(rows[:, :, 1], steps)
    enabled = [one for one in events if one["event"] == "enabled"]
    assert [one["cycle"] for one in enabled] == [0]
    assert not [one for one in events if one["event"] == "watchdog"]


def test_the_log_holds_what_the_master_read(tmp_path: Path) -> None:
    need_pysoem()
    with cable() as ends, drives(ends, tmp_path, "akd"):
        seen = session(ends, "akd")
    table = columns(tmp_path / "drives.csv")
    rows = np.array(seen["rows"], dtype=float)
    np.testing.assert_array_equal(np.rint(table["theta"][:CYCLES] / ANGLE_STEP), rows[:, :, 0])
    np.testing.assert_array_equal(table["time"][:CYCLES], np.arange(CYCLES) / 4000.0)


def test_the_same_session_gives_the_same_bits(tmp_path: Path) -> None:
    need_pysoem()
    digests = []
    for _ in range(2):
        with cable() as ends, drives(ends, tmp_path, "akd") as (events, _):
            session(ends, "akd")
        digests.append(events[-1]["digest"])
    assert digests[0] == digests[1]


def test_a_master_that_vanishes_ends_in_the_watchdog_at_its_cycle(tmp_path: Path) -> None:
    need_pysoem()
    # real seconds until the silence is noticed; the cycles do not depend on them
    with cable() as ends, drives(ends, tmp_path, "akd", "silence_s = 0.2") as (events, _):
        session(ends, "akd", "--vanish")
        time.sleep(1.0)
    silence = next(one for one in events if one["event"] == "silence")
    expired = [one["cycle"] for one in events if one["event"] == "watchdog"]
    # the last frame acted at CYCLES - 1; the default watchdog is 100 ms: 400 cycles
    assert silence["cycle"] == CYCLES
    assert expired == [CYCLES - 1 + 400] * 6
    assert [one["cycle"] for one in events if one["event"] == "torque_zero"] == expired
    faults = [one for one in events if one["event"] == "drive" and one["to"].startswith("fault")]
    assert {one["error"] for one in faults} == {0x8130}


def test_by_the_clock_no_frame_after_a_stall_is_answered_with_an_old_angle(tmp_path: Path) -> None:
    need_pysoem()
    options = paused(4000)
    with cable() as ends, drives(ends, tmp_path, "akd", options, lockstep=False) as (_, process):
        seen = session(ends, "akd", "--stalled", process, cycles=200)
    # a second under the torque of frame 199, of which the flywheel has the time constant 0.25 s
    speed = target(199, 0) * TORQUE_STEP["akd"] / FRICTION
    assert seen["moved"] / (speed * STALL_S / ANGLE_STEP) > 0.9


def test_an_independent_decoder_finds_no_malformed_frame(tmp_path: Path) -> None:
    need_pysoem()
    capture = tmp_path / "session.pcapng"
    with cable() as ends, drives(ends, tmp_path, "akd"), capturing(ends, capture):
        session(ends, "akd")
    frames = decode(capture, "-Y", "eth.type == 0x88a4")
    assert len(frames) > 2 * CYCLES, "there and back"
    assert any("'APWR'" in one for one in frames[:100]), "the configuration is part of it"
    assert len(decode(capture, "-Y", "ecat")) == len(frames), "each is decoded as EtherCAT"
    assert malformed(capture) == []


@pytest.mark.parametrize(("length", "wrong"), [(202, 0), (20, 1)])
def test_the_decoder_tells_a_short_frame_from_a_sound_one(
    length: int, wrong: int, tmp_path: Path
) -> None:
    need_tshark()
    # an LRW that says 200 bytes; with its working counter 202 follow the header
    frame = b"\xff" * 6 + b"\x10" * 6 + b"\x88\xa4" + struct.pack("<H", 0x1000 | 212)
    frame += struct.pack("<BBIHH", 12, 0, 0, 200, 0) + bytes(length)
    capture = tmp_path / "one.pcap"
    head = struct.pack("<IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 65535, 1)
    capture.write_bytes(head + struct.pack("<IIII", 0, 0, len(frame), len(frame)) + frame)
    assert len(malformed(capture)) == wrong


def refusal(*words: object) -> str:
    """Error text of an emulator that must not start."""
    program = built() / "flexhex-emulator"
    done = subprocess.run(list(map(str, [program, *words])), capture_output=True, text=True)
    assert done.returncode == 1, done.stderr
    assert "panicked" not in done.stderr
    return done.stderr


def test_refusals_say_what_is_wrong_and_how_to_mend_it(tmp_path: Path) -> None:
    options = tmp_path / "drives.toml"
    options.write_text("[[fault]]\nkind = 'frame_lost'\ncycle = 0\n")
    assert "`ip link` lists" in refusal("--interface", "nosuch0")
    assert "give --interface NAME" in refusal()
    assert "allowed akd or cst" in refusal("--interface", "lo", "--drives", "servo")
    assert "allowed 1 and up" in refusal("--interface", "lo", "--options", options)
    options.write_text("[drives]\ncuont = 3\n")
    said = refusal("--interface", "lo", "--options", options)
    assert "drives.toml" in said
    assert "cuont" in said
    assert "nosuch.ssp" in refusal("--interface", "lo", "--system", tmp_path / "nosuch.ssp")


def test_without_the_right_to_raw_frames_it_says_which_right() -> None:
    if shutil.which("setpriv") is None:
        pytest.skip("no setpriv")
    program = built() / "flexhex-emulator"
    words = ["setpriv", "--inh-caps=-net_raw", "--bounding-set=-net_raw", program]
    done = subprocess.run([*words, "--interface", "lo"], capture_output=True, text=True)
    if "setpriv:" in done.stderr:
        pytest.skip("setpriv needs root")
    assert done.returncode == 1
    assert "cap_net_raw" in done.stderr

"""An independent EtherCAT master (SOEM through pysoem) brings the drives to OP and cycles them.

    python pysoem_session.py INTERFACE akd|cst CYCLES [--vanish | --stalled PID]

--vanish: it ends in the middle of its cycles and leaves the drives in OP with power.
--stalled: in the end the drives' process PID stops before it answers a frame, and is continued.

Prints what it saw as one JSON object. Run as a program of its own, because a network namespace
belongs to a process.
"""

from __future__ import annotations

import json
import os
import signal
import struct
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pysoem

Write = Callable[[int, int, str, int], None]
PATIENCE_US = 2_000_000
"""A reply that takes longer is counted as lost. In lockstep it takes some 20 us, but on a busy
computer the other side may have to wait for its turn; SOEM's own 2 ms would lose frames then."""
STALL_S = 0.02
"""The drives' process stands still at least as long."""
SOON_US = 2_000
TIME_DIFFERENCE = 0x092C
FORMATS = {"akd": ("<HbBi", "<HbBiii"), "cst": ("<HbBh", "<HbBihH")}
MODES = {"akd": 4, "cst": 10}


def target(cycle: int, axis: int) -> int:
    """Steps of target current or torque: a slow staircase in both directions, no axis as another.

    Frame 0 is written before its reply says that the drives are enabled, so it asks for nothing.
    """
    return 0 if cycle == 0 else 20 * (axis + 1) * ((cycle // 250) % 5 - 2)


def write_map(write: Write, index: int, entries: Sequence[int]) -> None:
    """The entries of a map, as every drive wants them: none, each, how many."""
    write(index, 0, "<B", 0)
    for sub, entry in enumerate(entries, 1):
        write(index, sub, "<I" if index < 0x1C00 else "<H", entry)
    write(index, 0, "<B", len(entries))


def map_akd(slave: Any) -> None:
    """The layout with target current and position in the flexible maps."""

    def write(index: int, sub: int, form: str, value: int) -> None:
        slave.sdo_write(index, sub, struct.pack(form, value))

    write_map(write, 0x1600, [0x60400010, 0x60600008, 0x00000008, 0x20710020])
    write_map(write, 0x1A00, [0x60410010, 0x60610008, 0x00000008, 0x60630020])
    write_map(write, 0x1A01, [0x20770020, 0x606C0020])
    write_map(write, 0x1C12, [0x1600])
    write_map(write, 0x1C13, [0x1A00, 0x1A01])


def control(status: int) -> int:
    """The next step to "operation enabled"."""
    if status & 0x4F == 0x40:
        return 0x06
    return 0x07 if status & 0x6F == 0x21 else 0x0F


def abort_code(slave: Any, index: int, data: bytes | None) -> int:
    """Abort code of an SDO that a drive must refuse; 0: none."""
    try:
        if data is None:
            slave.sdo_read(index, 0)
        else:
            slave.sdo_write(index, 0, data)
    except pysoem.SdoError as refused:
        return int(refused.abort_code)
    return 0


def exchange(master: Any, outputs: Sequence[bytes]) -> int:
    """One frame with process data; its working counter."""
    for slave, output in zip(master.slaves, outputs, strict=True):
        slave.output = output
    master.send_processdata()
    return int(master.receive_processdata(PATIENCE_US))


def configure(master: Any, kind: str) -> dict[str, Any]:
    """INIT to OP."""
    seen: dict[str, Any] = {"found": master.config_init()}
    seen["identity"] = [[s.name, s.man, s.id, s.rev] for s in master.slaves]
    if kind == "akd":
        for slave in master.slaves:
            slave.config_func = lambda _, slave=slave: map_akd(slave)
    seen["image_bytes"] = master.config_map()
    seen["clocks"] = bool(master.config_dc())
    seen["safe_op"] = master.state_check(pysoem.SAFEOP_STATE, PATIENCE_US)
    first = master.slaves[0]
    seen["aborts"] = {
        "unknown": abort_code(first, 0x5000, None),
        "read only": abort_code(first, 0x6041, b"\0\0"),
        "map in SAFE-OP": abort_code(first, 0x1600, b"\0"),
    }
    seen["serial"] = [struct.unpack("<I", s.sdo_read(0x1018, 4))[0] for s in master.slaves]
    seen["name"] = first.sdo_read(0x1008, 0).decode()
    master.state = pysoem.OP_STATE
    master.write_state()
    exchange(master, [bytes(len(s.output)) for s in master.slaves])
    seen["op"] = master.state_check(pysoem.OP_STATE, PATIENCE_US)
    seen["expected_counter"] = master.expected_wkc
    return seen


def moved_in_a_stall(master: Any, kind: str, drives: int) -> int:
    """Counts that the first axis moves by while the drives' process stands still.

    It stops before it answers a frame; when it goes on, the next frame is waiting.
    """
    _, inp = FORMATS[kind]
    state = Path(f"/proc/{drives}/stat")
    while state.read_text().rpartition(")")[2].split()[0] != "T":
        before = struct.unpack(inp, master.slaves[0].input)[3]
        master.send_processdata()
        master.receive_processdata(SOON_US)
    time.sleep(STALL_S)
    master.send_processdata()
    os.kill(drives, signal.SIGCONT)
    assert master.receive_processdata(PATIENCE_US) == master.expected_wkc
    return int(struct.unpack(inp, master.slaves[0].input)[3] - before)


def cycle(master: Any, kind: str, cycles: int) -> dict[str, Any]:
    """Enables, then cycles of plant time under `target`; ends disabled."""
    out, inp = FORMATS[kind]
    status = [0x40] * len(master.slaves)
    counters, rows, n = set(), [], 0
    while n < cycles:
        moves = all(s & 0x6F == 0x27 for s in status)
        outputs = [
            struct.pack(out, control(s), MODES[kind], 0, target(n, axis) if moves else 0)
            for axis, s in enumerate(status)
        ]
        counters.add(exchange(master, outputs))
        inputs = [struct.unpack(inp, slave.input) for slave in master.slaves]
        status = [one[0] for one in inputs]
        if all(s & 0x6F == 0x27 for s in status):
            rows.append([[one[3], one[4]] for one in inputs])
            n += 1
    if "--vanish" in sys.argv:
        os._exit(0)
    seen: dict[str, Any] = {}
    if "--stalled" in sys.argv:
        seen["moved"] = moved_in_a_stall(master, kind, int(sys.argv[-1]))
    differences = [s._fprd(TIME_DIFFERENCE, 4) for s in master.slaves]
    exchange(master, [struct.pack(out, 0, MODES[kind], 0, 0)] * len(status))
    return seen | {
        "counters": sorted(counters),
        "rows": rows,
        "clock_ns": [int.from_bytes(d, "little") & 0x7FFFFFFF for d in differences[1:]],
    }


def main() -> None:
    """Everything between INIT and INIT."""
    interface, kind, cycles = sys.argv[1:4]
    for name in ("ret", "safe", "eeprom", "tx_mailbox", "rx_mailbox"):
        setattr(pysoem.settings.timeouts, name, PATIENCE_US)
    master = pysoem.Master()
    master.open(interface)
    try:
        seen = configure(master, kind)
        seen |= cycle(master, kind, int(cycles))
        master.state = pysoem.INIT_STATE
        master.write_state()
    finally:
        master.close()
    print(json.dumps(seen))


if __name__ == "__main__":
    main()

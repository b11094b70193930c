"""What the recorder of an AKD drive gives out, as `REC.RETRIEVE` prints it: no times, no units.

1000,16                    points, and the gap between them in periods of the recorder
IL.FB,PL.FB,VL.FB          the drive's parameters
-0.086,12.204,2.661        or F3-0x56,F30x2FAC,F30xA65: hexadecimal, in thousandths
[Kollmorgen, AKD Parameter and Command Reference Guide, REC.RETRIEVEFRMT, REC.GAP]
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.logs.csv_head import Header, decode
from flexhex.diagnosis.logs.dialects import translated
from flexhex.diagnosis.logs.log import Finding, Options
from flexhex.diagnosis.logs.raw import Column, Raw, Table, plan
from flexhex.fmus.common.errors import LogError

PERIOD = 62.5e-6
"""Of the recorder [s]: a gap of 1 is 16 kHz."""
MOST = 1 << 24
"""Bytes that are read: the drive keeps 10 000 points of six parameters."""
HEAD = re.compile(rb"^\s*(\d+)\s*,\s*(\d+)\s*$")
NAMES = re.compile(r"[A-Z][A-Z0-9]*(\.[A-Z][A-Z0-9]*)+")
INTERNAL = re.compile(r"^F(\d+)(-?)0x([0-9A-Fa-f]+)$")


def recorder(path: Path, options: Options) -> Raw | None:
    """The file, or None where it is another kind. LogError for one that cannot be read."""
    with path.open("rb") as file:
        head = HEAD.match(file.readline(1 << 10))
        names = [name.strip() for name in decode(file.readline(1 << 16)).split(",")]
        if not head or not all(map(NAMES.fullmatch, names)):
            return None
        text = decode(file.read(MOST))
    where, numbers = str(path), [int(n) for n in head.groups()]
    header = Header(["time", *names], [], {"logger": "AKD recorder"}, ",", 0)
    options, findings = translated(header, options, where)
    rows = _rows(text, len(names), where)
    # the number of points stands first, unless only the second can be it
    points, gap = numbers if numbers[1] != len(rows) else numbers[::-1]
    ts = max(gap, 1) * PERIOD
    said = f"recorder of an AKD drive: {len(rows)} of {points} points, {1e3 * ts:.6g} ms apart"
    findings.append(Finding("names", where, said, True))
    units = header.units or [""] * len(header.names)
    columns = [
        Column(k, name, unit)
        for k, (name, unit) in enumerate(zip(header.names[1:], units[1:], strict=True))
    ]
    known, more = plan(where, Column(None, "time", "s"), columns, options)
    values = {name: rows[:, list(keys)] for name, keys in known.keys.items()}
    time = np.arange(len(rows), dtype=np.float64) * ts
    table = Table(where, time, "s", values, dict(known.units))
    return Raw([table], header.meta, findings + more)


def _rows(text: str, width: int, where: str) -> NDArray[np.float64]:
    """The numbers (rows, width)."""
    rows = []
    for count, line in enumerate(text.splitlines(), start=3):
        fields = line.split(",")
        if not re.match(r"\s*[+.\dF]|\s*-[.\d]", line):
            continue  # blank, or the prompt `-->` of the drive
        if len(fields) != width:
            raise LogError(f"{where}: line {count} has {len(fields)} numbers, wanted {width}")
        rows.append([_number(field.strip(), where, count) for field in fields])
    if len(rows) < 2:
        raise LogError(f"{where}: no samples: the recorder of the drive holds none")
    return np.array(rows, dtype=np.float64)


def _number(field: str, where: str, line: int) -> float:
    internal = INTERNAL.match(field)
    try:
        if not internal:
            return float(field)
    except ValueError:
        raise LogError(f"{where}: line {line}: {field!r} is no number") from None
    value = int(internal[3], 16) / 10.0 ** int(internal[1])
    return -value if internal[2] else value

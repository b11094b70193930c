"""The head of a CSV that TwinCAT Scope exports: a block on the scope, one on its channels, numbers.

Name	SCOPE
Starttime of export	132959733843760000	...

Name	AXIS 1	AXIS 2	Name	TORQUE 1     "Name" stands above each column of times [ms]
SampleTime[ms]	1	1	SampleTime[ms]	1
Unit	deg	(None)	Unit	N m (Torque)

0	1,5	0	0	0,25
[Beckhoff, TE13xx TwinCAT 3 Scope View, "Export in CSV"]
"""

from __future__ import annotations

import re
from typing import BinaryIO

from flexhex.diagnosis.logs.csv_head import LONGEST_LINE, Header, decode, split_fields
from flexhex.fmus.common.errors import LogError

FIRST, STARTS = "Name", ("Starttime of export", "StartRecord")
"""First field of the head, and of its second or third line."""
LINES = 60
"""Most lines of a head."""
FILETIME = 1e15
"""Times beyond it count 100 ns since 1601: a double keeps them to some microseconds only."""
MILLISECONDS = "ms"


def scope_header(file: BinaryIO, where: str) -> Header | None:
    """The head, with `time` above the times; None where it is another file's. LogError for an
    export without times, or with times of the calendar."""
    file.seek(0)
    title = decode(file.readline(LONGEST_LINE)).strip("\r\n")
    early = [decode(file.readline(LONGEST_LINE)).lstrip('"') for _ in range(3)]
    if title[: len(FIRST)] != FIRST or not any(line.startswith(STARTS) for line in early):
        return None
    separator = title[len(FIRST) : len(FIRST) + 1]
    names: list[str] = []
    units: list[str] = []
    for _ in range(LINES):
        start, line = file.tell(), decode(file.readline(LONGEST_LINE)).strip("\r\n")
        fields = split_fields(line, separator) or [""]
        if names and re.match(r"-?\d", fields[0]):
            return _header(where, names, units, separator, start, fields)
        if fields[0] == FIRST and not names:
            names = fields
        elif fields[0] == "Unit":
            units = fields
    raise LogError(
        f"{where}: an export of TwinCAT Scope without times: export it again as CSV with Timelines"
        " `All` or `For each sampletime`"
    )


def _header(
    where: str, names: list[str], units: list[str], separator: str, start: int, first: list[str]
) -> Header:
    while names and not names[-1]:
        names = names[:-1]
    if float(first[0].replace(",", ".")) > FILETIME:
        raise LogError(
            f"{where}: times of the calendar (Full Timestamp), which are too coarse for rates:"
            " export it again without them"
        )
    shown = ["time" if name == FIRST else name for name in names]
    known = [_unit(unit) for unit in (units + [""] * len(names))[: len(names)]]
    completed = [MILLISECONDS if n == FIRST else u for n, u in zip(names, known, strict=True)]
    return Header(shown, completed, {"logger": "TwinCAT Scope"}, separator, start, ragged=True)


def _unit(text: str) -> str:
    """`N m` of `N m (Torque)`, nothing of `(None)`."""
    return re.sub(r"\s*\(.*\)$", "", text).strip()

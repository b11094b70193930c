"""The lines of a CSV log before its numbers: metadata, names, units; encoding and separator."""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass
from itertools import count
from typing import BinaryIO

from flexhex.fmus.common.errors import LogError

LONGEST_LINE = 1 << 20
HEADER_ROWS = 12
TIMES = ("time", "t")
UTF_16 = re.compile(rb"\xff\xfe|\xfe\xff|[!-~]\0|\0[!-~]")
"""How UTF-16 text begins: with its mark, or with a character that ASCII has."""


@dataclass
class Header:
    """What stands before the numbers; start: byte at which they begin. ragged: columns on the right
    may end earlier than others, as those of slower channels do. suffix: what stands behind every
    time, as in a timetable of MATLAB. lines: numbers of the lines of names and of units."""

    names: list[str]
    units: list[str]
    meta: dict[str, str]
    separator: str
    start: int
    decimal_comma: bool = False
    ragged: bool = False
    suffix: bytes = b""
    lines: tuple[int, int] = (1, 2)

    @property
    def title(self) -> str:
        """What is said where names stand in the line of units, as below a title; or nothing."""
        below = self.separator.join(self.units)
        fields = [name.lower() for name in split_fields(below, _separator(below))]
        if not set(fields) & set(TIMES) or {n.lower() for n in self.names} & set(TIMES):
            return ""
        first, second = self.lines
        shown = self.separator.join(self.names)
        return (
            f"line {first} ({shown[:40]!r}) is no row of names, which line {second} seems to be: a"
            " title above the names? begin its line with #"
        )

    def uneven(self, names: int) -> str:
        """What is said where there are so many names, and another number of units."""
        first, second = self.lines
        return (
            f"line {first} has {names} names but line {second} has {len(self.units)} units: give"
            " each column one"
        )


def decode(line: bytes) -> str:
    """Text in UTF-8, with or without its mark, or else in Windows' Western encoding."""
    try:
        return line.decode("utf-8-sig")
    except UnicodeDecodeError:
        return line.decode("cp1252", errors="replace")


def _number(field: str) -> bool:
    try:
        float(field.strip().replace(",", "."))
    except ValueError:
        return False
    return True


def read_header(file: BinaryIO, where: str) -> Header:
    """Everything up to the first row of numbers. LogError when no row of names is there."""
    file.seek(0)
    if UTF_16.match(file.read(2)):
        raise LogError(f"{where}: is UTF-16 text: save it as CSV in UTF-8")
    file.seek(0)
    meta: dict[str, str] = {}
    names: list[str] = []
    units: list[str] = []
    separator, rows, fields, lines = "", 0, list[str](), [0, 0]
    for number in count(1):
        start = file.tell()
        line = file.readline(LONGEST_LINE)
        text = decode(line).strip("\r\n\0 ")
        if not line or rows > HEADER_ROWS:
            break
        if text.lower().startswith("sep=") and not names:
            separator = text[4:5]
        elif text.lstrip('"').startswith("#"):
            key, _, value = text.strip('"').lstrip("# ").partition(":")
            meta[key.strip().lower()] = value.strip(' \t",;')
        elif text.strip(",;\t "):
            separator = separator or _separator(text)
            fields = split_fields(text, separator)
            numbers = sum(map(_number, fields))
            if numbers and 2 * numbers > sum(bool(f) for f in fields):
                break
            rows += 1
            if not names:
                names, lines = fields, [number, number + 1]
            elif not units or any(f.lower().startswith("unit:") for f in fields):
                units, lines[1] = [_after(f, "unit:") for f in fields], number
    if not names:
        what = "no row of names" if file.tell() else "an empty file"
        raise LogError(f"{where}: {what}: its first row wants time,theta[1], ...")
    header = Header(names, units, meta, separator or ",", start, lines=(lines[0], lines[1]))
    return _timetable(header, fields, where)


def _timetable(header: Header, first: list[str], where: str) -> Header:
    """A header whose times are durations as MATLAB writes them, `0.001 sec`: known to be seconds.
    LogError for clock times."""
    time = next((k for k, name in enumerate(header.names) if name.lower() in TIMES), None)
    text = first[time] if time is not None and time < len(first) else ""
    if re.fullmatch(r"(\d+:)?\d+:\d+(\.\d+)?", text):
        raise LogError(
            f"{where}: {header.names[time or 0]} {text!r} is a clock time: write seconds (in MATLAB"
            " TT.Time.Format = 's' before writetimetable)"
        )
    if time is not None and re.fullmatch(r"[-+.\deE]+ sec", text):
        header.suffix = b" sec"
        header.units = [*header.units] or [""] * len(header.names)
        header.units[time] = header.units[time] or "s"
    return header


def _separator(text: str) -> str:
    """What stands between the fields of a row; spaces where there is nothing else."""
    best = max(";\t,", key=text.count)
    return best if best in text or " " not in text else " "


def split_fields(text: str, separator: str) -> list[str]:
    """The fields of a line without their quotes."""
    try:
        return [f.strip() for f in next(csv.reader([text], delimiter=separator))]
    except (csv.Error, StopIteration):
        return [f.strip(' "') for f in text.split(separator)]


def _after(field: str, prefix: str) -> str:
    return field[len(prefix) :].strip() if field.lower().startswith(prefix) else field

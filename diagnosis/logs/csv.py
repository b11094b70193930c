"""CSV logs, read in blocks: only the wanted columns of one block are ever parsed at a time.

`# key: value` lines are metadata, then a row of names and a row of units. Separators (comma,
semicolon, tab), decimal commas, a byte order mark, the `Unit:` rows of Simulink's Data
Inspector and the `sep=;` line of Excel are recognised and said.
"""

from __future__ import annotations

import io
import math
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

import numpy as np

from flexhex.diagnosis.logs.akd import recorder
from flexhex.diagnosis.logs.csv_head import TIMES, Header, decode, read_header
from flexhex.diagnosis.logs.dialects import translated
from flexhex.diagnosis.logs.log import Array, Finding, Options
from flexhex.diagnosis.logs.raw import (
    Column,
    Plan,
    Raw,
    Table,
    memory_finding,
    plan,
    split_unit,
    stretches,
)
from flexhex.diagnosis.logs.twincat import scope_header
from flexhex.fmus.common.errors import LogError

BLOCK = 1 << 23
"""Bytes that are parsed at a time."""


def read_csv(path: Path, options: Options) -> Raw:
    """Read a CSV log; LogError tells file, column and remedy."""
    where = str(path)
    if recorded := recorder(path, options):
        return recorded
    with path.open("rb") as file:
        header = scope_header(file, where) or read_header(file, where)
        options, known = translated(header, options, where)
        plans, findings = _plans(header, where, options)
        findings = known + findings
        file.seek(header.start)
        rows = _count(file)
        if rows < 1:
            text = "no samples: wants a row of names, a row of units, then numbers"
            raise LogError(f"{where}: {text}")
        header.decimal_comma = _decimal_comma(file, header, where)
        if header.decimal_comma:
            findings.append(Finding("conversion", where, "decimal commas read as points", True))
        reader = _Reader(file, header, where, [c for p in plans for c in _keys(p)])
        columns = sum(p.columns for p in plans)
        most = max(int(options.memory / (8 * columns)), 1000)
        tables, more = _fill(reader, plans, rows, most)
    return Raw(tables, header.meta, findings + more)


def _keys(one: Plan) -> list[int]:
    return [one.time.key, *(key for keys in one.keys.values() for key in keys)]


def _plans(header: Header, where: str, options: Options) -> tuple[list[Plan], list[Finding]]:
    """One plan for each time column with the channels that stand behind it."""
    names, units = header.names, header.units
    names = names[: max(len(units), max((k for k, n in enumerate(names, 1) if n), default=0))]
    if units and len(names) != len(units):
        raise LogError(f"{where}: {header.title or header.uneven(len(names))}")
    columns = []
    for k, name in enumerate(names):
        plain, unit = split_unit(name)
        own = units[k] if units else ""
        # a renamed header counts as it stands, with the unit in it
        columns.append(Column(k, name if name in options.rename else plain, own or unit))
    times = [k for k, c in enumerate(columns) if _is_time(c.name, options)]
    if not times:
        listed = ", ".join(name for name in names[:12] if name.isprintable() and name)
        request = f"{listed}: say which it is, --rename 'COLUMN=time'"
        shown = request if listed else "no names: is it a CSV file?"
        raise LogError(f"{where}: {header.title or f'no channel `time`; it has {shown}'}")
    plans, findings = [], []
    for k, end in zip(times, [*times[1:], len(columns)], strict=True):
        # a single time column may stand anywhere
        begin = 0 if len(times) == 1 else k
        mine = [c for c in columns[begin:end] if c.key != k and c.name]
        one, more = plan(where, columns[k], mine, options)
        plans.append(one)
        findings += more
    return plans, findings


def _is_time(name: str, options: Options) -> bool:
    return options.rename.get(name, name).strip().lower() in TIMES


def _count(file: BinaryIO) -> int:
    """Lines from here to the end."""
    lines, last = 0, b"\n"
    while block := file.read(BLOCK):
        lines += block.count(b"\n")
        last = block[-1:]
    return lines + (last != b"\n")


def _decimal_comma(file: BinaryIO, header: Header, where: str) -> bool:
    file.seek(header.start)
    text = decode(file.read(1 << 16))
    if header.separator == "," or "," not in text:
        return False
    fields = [f for line in text.splitlines()[:-1] or [text] for f in line.split(header.separator)]
    both = next((f for f in fields if "," in f and "." in f), None)
    if both is not None:
        text = f"{both!r} has a comma and a point: write numbers without thousands"
        raise LogError(f"{where}: {text}")
    return any("," in f for f in fields)


class _Reader:
    """Parses blocks of lines into the wanted columns (rows, wanted)."""

    def __init__(self, file: BinaryIO, header: Header, where: str, wanted: list[int]) -> None:
        self.file, self.header, self.where, self.wanted = file, header, where, wanted
        self.width = len(header.names)
        self.bad_rows = 0
        self.blanks = 0

    def blocks(self, begin: int, end: int) -> Iterator[Array]:
        """Rows whose line begins in [begin, end) of the file's bytes."""
        self.file.seek(begin)
        while self.file.tell() < end:
            block = self.file.read(min(BLOCK, end - self.file.tell())) + self.file.readline()
            if not block.strip():
                continue
            yield self.parse(block)

    def parse(self, block: bytes) -> Array:
        """Wanted columns of whole lines; blanks and words become NaN, ragged rows are left out."""
        block = block.replace(b"\r\n", b"\n").replace(b"\r", b"\n").replace(b'"', b"")
        block = block.replace(self.header.suffix, b"")
        if b"#" in block:
            rows = block.split(b"\n")
            block = b"\n".join(line for line in rows if not line.lstrip().startswith(b"#"))
        if self.header.decimal_comma:
            block = block.replace(b",", b".")
        separator = self.header.separator.encode()
        lines = block.count(b"\n") + (not block.endswith(b"\n"))
        if block.count(separator) == lines * (self.width - 1) and b"\n\n" not in block:
            for text in (block, _blanks_named(block, separator)):
                try:
                    numbers = np.loadtxt(
                        io.BytesIO(text),
                        delimiter=self.header.separator,
                        usecols=self.wanted,
                        ndmin=2,
                        comments=None,
                        encoding="latin-1",
                    )
                except ValueError:
                    continue
                return np.asarray(numbers, dtype=np.float64)
        return self._slow(block)

    def _slow(self, block: bytes) -> Array:
        rows = []
        for line in block.decode("latin-1").split("\n"):
            if not line.strip():
                continue
            fields = line.split(self.header.separator)
            while len(fields) > self.width and not fields[-1].strip():
                fields.pop()
            fields += [""] * (self.width - len(fields)) * self.header.ragged
            if len(fields) != self.width:
                self.bad_rows += 1
                continue
            rows.append([_float(fields[k]) for k in self.wanted])
        return np.array(rows, dtype=np.float64).reshape(-1, len(self.wanted))


def _blanks_named(block: bytes, separator: bytes) -> bytes:
    """Empty fields as nan, so that the fast parser takes them."""
    for _ in range(2):
        block = block.replace(separator + separator, separator + b"nan" + separator)
    block = block.replace(separator + b"\n", separator + b"nan\n")
    block = block.replace(b"\n" + separator, b"\nnan" + separator)
    block = b"nan" + block if block.startswith(separator) else block
    return block + b"nan" if block.endswith(separator) else block


def _float(field: str) -> float:
    try:
        return float(field)
    except ValueError:
        return math.nan


def _fill(
    reader: _Reader, plans: list[Plan], rows: int, most: int
) -> tuple[list[Table], list[Finding]]:
    """Read the wanted stretches into one array a channel, laid out before anything is read."""
    parts = stretches(rows, most)
    size = reader.file.seek(0, io.SEEK_END)
    start = reader.header.start
    byte = [start + (size - start) * row // rows for part in parts for row in part]
    # stretches are cut by bytes: leave room for lines shorter than the mean
    room = rows if len(parts) == 1 else int(1.2 * most) + 1000
    arrays = [{name: np.empty((room, len(keys))) for name, keys in p.keys.items()} for p in plans]
    times = [np.empty(room) for _ in plans]
    done, joins = 0, []
    for k, (begin, end) in enumerate(zip(byte[::2], byte[1::2], strict=True)):
        if k:
            reader.file.seek(begin)
            reader.file.readline()
            begin = reader.file.tell()
            joins.append(done)
        for block in reader.blocks(begin, end):
            block = block[: room - done]
            _store(block, slice(done, done + len(block)), plans, times, arrays)
            done += len(block)
    tables = []
    for p, time, values in zip(plans, times, arrays, strict=True):
        cut = {name: array[:done] for name, array in values.items()}
        where = reader.where
        tables.append(Table(where, time[:done], p.time.unit, cut, dict(p.units), tuple(joins)))
    findings = []
    if len(parts) > 1:
        findings.append(memory_finding(done / rows, len(parts), reader.where))
    if reader.bad_rows:
        text = f"{reader.bad_rows} rows do not have {reader.width} fields and are left out"
        if done == 0:
            raise LogError(f"{reader.where}: {text}: is the separator {reader.header.separator!r}?")
        findings.append(Finding("bad-rows", reader.where, text, False))
    return tables, findings


def _store(
    block: Array, to: slice, plans: list[Plan], times: list[Array], arrays: list[dict[str, Array]]
) -> None:
    """Deal the columns of a block out to times and channels, in the order they were asked for."""
    column = 0
    for p, time, values in zip(plans, times, arrays, strict=True):
        time[to] = block[:, column]
        column += 1
        for name, keys in p.keys.items():
            values[name][to] = block[:, column : column + len(keys)]
            column += len(keys)

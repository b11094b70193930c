"""Results in CSV, the layout of measured logs: `# key: value`, names, units, then the numbers.

Each rate has a time column with its signals behind it. They stand side by side, and a slower
rate ends earlier: its last rows are blank. All numbers read back exactly. Lines `# rate`,
`# signal` and `# fmu` carry what a table cannot, as JSON.
"""

from __future__ import annotations

import csv
import json
from collections.abc import Iterator
from itertools import islice, zip_longest
from pathlib import Path
from typing import Any, TextIO
from urllib.parse import unquote

import numpy as np

from flexhex.fmus.common.errors import LogError
from flexhex.fmus.common.interface import indices
from flexhex.ssp.result import FORMAT, VERSION, Array, FmuTime, Group, Meta, Result, plain

BLOCK = 4096
"""Rows that are written at a time."""
HEAD = ("format", "version", "base_step_s", "duration_s", "wall_s")


def write(path: Path, result: Result, meta: Meta) -> None:
    """Write the result; OSError when that fails."""
    with path.open("w", encoding="utf-8", newline="") as file:
        for key, value in _head(result, meta):
            file.write(f"# {_quoted(key)}: {value}\n")
        table = csv.writer(file, lineterminator="\n")
        table.writerow(_names(result))
        table.writerow(
            unit
            for group in result.groups.values()
            for unit in ["s", *(u for s in group.signals for u in group.column_units(s))]
        )
        blank = ["," * (len(_group_names(group)) - 1) for group in result.groups.values()]
        for cells in zip_longest(*map(_rows, result.groups.values())):
            parts = (b if cell is None else cell for cell, b in zip(cells, blank, strict=True))
            file.write(",".join(parts) + "\n")


def _head(result: Result, meta: Meta) -> Iterator[tuple[str, str]]:
    """Keys and texts of the lines before the table."""
    base = next(group.base for group in result.groups.values())
    values: tuple[str | float, ...] = (FORMAT, VERSION, base, result.duration, result.wall)
    yield from zip(HEAD, map(_text, values), strict=True)
    for key in sorted(meta):
        yield key, _text(plain(meta[key]))
    for rate, group in result.groups.items():
        yield f"rate {rate}", json.dumps({"period": group.period, "rows": group.rows})
        for signal, values_of in group.signals.items():
            about = {
                "rate": rate,
                "columns": values_of.shape[1] if values_of.ndim > 1 else None,
                "unit": group.units.get(signal, ""),
                "description": group.descriptions.get(signal, ""),
            }
            yield f"signal {signal}", json.dumps(about, ensure_ascii=False)
    for name, spent in result.times.items():
        yield f"fmu {name}", json.dumps(vars(spent), ensure_ascii=False)


def _names(result: Result) -> list[str]:
    return [name for group in result.groups.values() for name in _group_names(group)]


def _group_names(group: Group) -> list[str]:
    return ["time", *(name for signal in group.signals for name in group.columns(signal))]


def _rows(group: Group) -> Iterator[str]:
    """Each sample of a group as text that reads back exactly."""
    for first in range(0, group.rows, BLOCK):
        for row in group.table(first, min(first + BLOCK, group.rows)).tolist():
            yield ",".join(map(repr, row))


def _quoted(key: str) -> str:
    """A key without colons and line breaks."""
    for sign in "%:\r\n":
        key = key.replace(sign, f"%{ord(sign):02X}")
    return key


def _text(value: str | float) -> str:
    """A value of the metadata; a text that could be taken for something else stands in quotes."""
    if not isinstance(value, str):
        return repr(value)
    safe = value.isprintable() and value == value.strip() and _value(value) == value
    return value if safe else json.dumps(value)


def _value(text: str) -> str | int | float:
    if text.startswith('"'):
        return str(json.loads(text))
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text


def read(path: Path) -> Result:
    """Read a result that `write` wrote. LogError when it is none, or damaged."""
    try:
        with path.open(encoding="utf-8", newline="") as file:
            head, names = _read_head(file)
            if head.get("format") != FORMAT:
                raise LogError(
                    f"{path}: a CSV file, but not a result: it has no line `# format: {FORMAT}`"
                )
            if head["version"] != str(VERSION):
                raise LogError(
                    f"{path}: version {head['version']} of the format, this program reads {VERSION}"
                )
            lines = file.readlines()
        return _result(head, names, lines)
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise LogError(f"{path}: a damaged result, maybe truncated ({error})") from None


def _read_head(file: TextIO) -> tuple[dict[str, str], list[str]]:
    """Lines before the numbers: texts by key, and the names; the units stand at the signals."""
    head: dict[str, str] = {}
    for line in file:
        if not line.startswith("#"):
            next(file, "")
            return head, next(csv.reader([line]))
        key, _, text = line[1:].strip().partition(":")
        head[unquote(key.strip())] = text.strip()
    return head, []


def _result(head: dict[str, str], names: list[str], lines: list[str]) -> Result:
    base = float(head["base_step_s"])
    about: dict[str, dict[str, Any]] = {"rate": {}, "signal": {}, "fmu": {}}
    meta = {}
    for key, text in list(head.items())[len(HEAD) :]:
        kind, _, name = key.partition(" ")
        if kind in about and text.startswith("{"):
            about[kind][name] = json.loads(text)
        else:
            meta[key] = _value(text)
    groups, first = {}, 0
    for rate, entry in about["rate"].items():
        signals = {k: s for k, s in about["signal"].items() if s["rate"] == rate}
        width = 1 + sum(s["columns"] or 1 for s in signals.values())
        values = _numbers(lines, range(first, first + width), entry["rows"])
        columns = names[first : first + width]
        groups[rate] = _group(entry["period"], base, signals, values, columns)
        first += width
    times = {name: FmuTime(**spent) for name, spent in about["fmu"].items()}
    result = Result(groups, times, float(head["duration_s"]), float(head["wall_s"]), meta)
    if not groups or names != _names(result):
        raise ValueError("its names are not those of its lines `# signal`")
    return result


def _numbers(lines: list[str], columns: range, rows: int) -> Array:
    """The columns of one rate (rows, columns)."""
    if rows > len(lines) or rows < 1:
        raise ValueError(f"{len(lines)} of {rows} rows")
    part = islice(lines, rows)
    return np.loadtxt(part, delimiter=",", usecols=columns, ndmin=2, comments=None)


def _group(
    period: int, base: float, about: dict[str, dict[str, Any]], values: Array, names: list[str]
) -> Group:
    signals, elements, first = {}, {}, 1
    for name, entry in about.items():
        size = entry["columns"]
        block = values[:, first : first + (size or 1)]
        signals[name] = block[:, 0] if size is None else block
        each = tuple(n.removeprefix(name) for n in names[first : first + (size or 1)])
        if size is not None and each != indices(size):
            elements[name] = each
        first += size or 1
    units = {name: entry["unit"] for name, entry in about.items()}
    descriptions = {name: entry["description"] for name, entry in about.items()}
    return Group(period, base, signals, units, descriptions, elements)

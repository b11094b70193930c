"""What a file holds before anything is judged: tables, each with one time column."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from flexhex.diagnosis.logs.log import Array, Finding, Options
from flexhex.diagnosis.logs.units import each_unit
from flexhex.fmus.common.errors import LogError

CHANNELS = (
    "theta",
    "tau_meas",
    "current",
    "voltage",
    "thetad",
    "thetadd",
    "r",
    "tau",
    "tau_ff",
    "payload",
    "temperature",
)
PAYLOAD = re.compile(r"\+?(\d+\.?\d*(?:[eE][-+]?\d+)?|\.\d+)\s*(kg|g|)")
"""What the head of a log may say of one."""
SCALARS = ("payload", "temperature")
"""Channels of width one, written without an index."""
STRETCHES = 24
ABSURD = 1e15
"""No measurement has such a value, in any unit: bytes that were none."""
_INDEX = re.compile(r"^(?P<base>.*?)\s*(?:\[(\d+)\]|\((\d+)\)|_(\d+)|(?<=[A-Za-z])(\d+))$")
_UNIT = re.compile(
    r"^(?P<name>.*?)\s*(?:\[(?P<a>[^\]\d][^\]]*)\]|\((?P<b>[^)\d][^)]*)\)|/\s*(?P<c>[^\d\s/]+))$"
)


@dataclass
class Table:
    """Channels that share one time column. time (samples,) in `unit`; values: (samples, width)
    by channel; units: of its axes, as the file has them; joins: rows at which a stretch begins that
    does not follow the row before it; stated: whether the file itself tells the units, not the kind
    of file that it is."""

    where: str
    time: Array
    unit: str
    values: dict[str, Array] = field(default_factory=dict)
    units: dict[str, tuple[str, ...]] = field(default_factory=dict)
    joins: tuple[int, ...] = ()
    stated: bool = True


@dataclass(frozen=True)
class Column:
    """One column of a file: its name and unit as written there, key: how its reader finds it."""

    key: Any
    name: str
    unit: str


@dataclass(frozen=True)
class Plan:
    """What to read for one time column: keys and units by channel in the order of the axes."""

    time: Column
    keys: Mapping[str, tuple[Any, ...]]
    units: Mapping[str, tuple[str, ...]]

    @property
    def columns(self) -> int:
        """Number of columns with the time."""
        return 1 + sum(len(keys) for keys in self.keys.values())


@dataclass
class Raw:
    """A file: its tables, metadata and what was noticed while reading it."""

    tables: list[Table]
    meta: dict[str, str]
    findings: list[Finding]


def without_absurd(table: Table) -> list[Finding]:
    """Values that nothing can have become NaN, with a finding for each channel."""
    findings = []
    for name, values in {"time": table.time, **table.values}.items():
        ends = (of.reduce(values, axis=None, initial=0.0) for of in (np.fmax, np.fmin))
        if max(map(abs, ends)) < ABSURD:
            continue
        absurd = np.abs(values) >= ABSURD
        first = tuple(int(k) for k in np.argwhere(absurd)[0])
        at = f"{name}[{first[1] + 1}]" if len(first) > 1 and values.shape[1] > 1 else name
        more = f" ({absurd.sum()} such values)" if absurd.sum() > 1 else ""
        text = (
            f"{at} is {values[first]:.3g} in sample {first[0] + 1}{more}: taken as missing; was the"
            " file damaged, or written while it was read?"
        )
        findings.append(Finding("nan", table.where, text, True))
        cleaned = np.where(absurd, np.nan, values)
        if name == "time":
            table.time = cleaned
        else:
            table.values[name] = cleaned
    return findings


def no_log(path: Path) -> str:
    """Why a file of a kind that is not read is none, and what mends it."""
    suffix = path.suffix.lower()
    if suffix in (".urdf", ".xml", ".sdf"):
        return f"a robot's file is no log: give it as --base {path}"
    if suffix == ".toml":
        return (
            f"a machine file is no log: give a hexapod's as --machine {path}, one beside a robot's"
            f" file as --base {path}"
        )
    ways = {
        ".bag": "`rosbags-convert` (PyPI: rosbags) makes a .mcap of a ROS 1 bag",
        ".npz": "write its arrays as columns of a CSV, names and units above (docs/diagnose.md)",
        ".npy": "write its columns as a CSV, names and units above (docs/diagnose.md)",
        ".pkl": "write its arrays as columns of a CSV, names and units above (docs/diagnose.md)",
        ".xlsx": "save the sheet as CSV",
    }
    others = "write CSV or HDF5 (.csv, .h5), or .mat, .parquet, .mf4, .mcap, .db3"
    return f"unknown kind {path.suffix!r}; {ways.get(suffix, others)}"


def split_unit(name: str) -> tuple[str, str]:
    """`theta[1] [deg]` and `theta (deg)` as name and unit; "" when it tells none."""
    match = _UNIT.match(name)
    if not match:
        return name, ""
    return match["name"], match["a"] or match["b"] or match["c"]


def channel_of(name: str, options: Options) -> tuple[str, int]:
    """Channel and number of the axis of a column; ("", 0) when it is none of ours.

    `theta[1]`, `theta(1)`, `theta_1` and `theta1` are alike; what stands before a dot
    (`plant.theta[1]`) does not count. Number 0 means "no number".
    """
    name = options.rename.get(name, name).strip()
    if name in CHANNELS:
        return name, 0
    tail = name.rsplit(".", 1)[-1]
    match = _INDEX.match(tail)
    base = match["base"] if match else tail
    number = next((int(g) for g in match.groups()[1:] if g is not None), 0) if match else 0
    base = options.rename.get(base, base)
    return (base, number) if base in CHANNELS else ("", 0)


def plan(
    where: str, time: Column, columns: Sequence[Column], options: Options
) -> tuple[Plan, list[Finding]]:
    """Sort the columns beside one time column into channels; what is not ours is a finding.

    LogError when a channel has an axis twice or a number is missing.
    """
    columns_of: dict[str, dict[int, Column]] = {}
    extra: list[str] = []
    for column in columns:
        name, number = channel_of(column.name, options)
        if not name:
            extra.append(column.name)
        elif number in columns_of.setdefault(name, {}):
            raise LogError(f"{where}: {column.name} stands there twice: keep one of them")
        else:
            columns_of[name][number] = column
    findings = []
    if extra:
        listed = ", ".join(extra[:6]) + (" ..." if len(extra) > 6 else "")
        findings.append(Finding("extra", where, f"not used: {listed}", True))
    keys, units = {}, {}
    for name, axes in columns_of.items():
        findings += _numbers(where, name, axes)
        ordered = [axes[k] for k in sorted(axes)]
        keys[name] = tuple(column.key for column in ordered)
        # an array has one text for all its axes: `rad, m`
        texts = [each_unit(where, name, column.unit, len(ordered)) for column in ordered]
        units[name] = tuple(of[k] for k, of in enumerate(texts))
    return Plan(time, keys, units), findings


def _numbers(where: str, name: str, axes: Mapping[int, Column]) -> list[Finding]:
    first, last = min(axes), max(axes)
    missing = [k for k in range(first, last) if k not in axes]
    if missing or first > 1:
        gap = missing[0] if missing else 1
        raise LogError(f"{where}: {name}[{gap}] is missing: number them from 1 without gaps")
    if first == 0 and last > 0:
        text = f"{name} is numbered from 0: {name}[0] is taken as axis 1"
        return [Finding("names", where, text, True)]
    return []


def stretches(rows: int, most: int) -> list[tuple[int, int]]:
    """Evenly spread [begin, end) that hold about `most` of `rows` rows; one when all fit."""
    if rows <= most:
        return [(0, rows)]
    length = max(most // STRETCHES, 1)
    first = np.linspace(0, rows - length, STRETCHES).astype(int)
    return [(int(a), int(a) + length) for a in first]


def picked(
    rows: int, columns: int, options: Options, where: str
) -> tuple[list[tuple[int, int]], list[Finding]]:
    """Which rows of a table with so many columns to keep in memory, and the finding."""
    most = max(int(options.memory / (8 * max(columns, 1))), 1000)
    kept = stretches(rows, most)
    if len(kept) == 1:
        return kept, []
    share = sum(b - a for a, b in kept) / rows
    return kept, [memory_finding(share, len(kept), where)]


def memory_finding(share: float, count: int, where: str) -> Finding:
    """Says that only stretches were read."""
    text = (
        f"too long for the memory allowed: {count} evenly spread stretches ({share:.0%}) are used"
    )
    return Finding("memory", where, text, False)


def texts(where: str, meta: Mapping[str, object]) -> dict[str, str]:
    """Metadata as text, keys in small letters, a payload in kg. LogError for one that is none."""
    told = {str(key).strip().lower(): str(value).strip() for key, value in meta.items()}
    if payload := told.pop("payload", ""):
        match = PAYLOAD.fullmatch(payload)
        if match is None:
            raise LogError(f"{where}: payload is {payload!r}, wanted in kg or g, as in '0.8 kg'")
        told["payload"] = f"{float(match[1]) / 1e3:g} kg" if match[2] == "g" else payload
    return told


def joins_of(parts: Sequence[tuple[int, int]]) -> tuple[int, ...]:
    """Rows at which the parts but the first begin once they stand one after another."""
    ends = np.cumsum([end - begin for begin, end in parts])
    return tuple(int(end) for end in ends[:-1])

"""A trajectory file: a CSV of reference angles or of poses of the end-effector, at any times.

A row of names, a row of units, then numbers, as in logs. Nothing is guessed or repaired: a motion
that is not quite what its author meant moves a machine.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.logs.csv_head import Header, decode, read_header
from flexhex.diagnosis.logs.units import ANGLE, LENGTH, RATE, SPEED, TIME
from flexhex.fmus.common.errors import TrajectoryError, unreadable
from flexhex.fmus.common.interface import indices
from flexhex.fmus.common.model.geometry import AXES
from flexhex.fmus.player.interface import MAX_PAYLOAD
from flexhex.fmus.player.table import Kind

Array = NDArray[np.float64]
MOST_ROWS = 100_000
"""Rows become C source: a compiler needs 6 s and 0.5 GB for these."""
Units = Mapping[str, float]


def _per_second(rates: Units) -> Units:
    """rad/s2 from rad/s; units that do not end in /s have no second derivative."""
    return {f"{unit}2": scale for unit, scale in rates.items() if unit.endswith("/s")}


DERIVATIVES: Mapping[str, tuple[Units, Units, Units]] = {
    "r": (ANGLE, RATE, _per_second(RATE)),
    "x": (LENGTH, SPEED, _per_second(SPEED)),
    "lam": ({"1": 1.0}, {"1/s": 1.0}, {"1/s2": 1.0}),
    "phi": (ANGLE, RATE, _per_second(RATE)),
}
"""Units of each quantity, its rate and its acceleration, with what they are in SI units."""
_POINT = tuple(f".{axis}" for axis in AXES)
SUFFIXES = {"r": indices(6), "x": _POINT, "lam": indices(4), "phi": _POINT}
"""What follows a quantity's name in those of its elements."""
WANTED = "r[1] to r[6], or x_E.x, .y, .z with lam_E[1] to [4] or phi_E.x, .y, .z"
KINDS: Mapping[tuple[str, ...], Kind] = {
    ("r",): "joints",
    ("x", "lam"): "pose",
    ("x", "phi"): "pose",
}
"""What stands together in a file."""


def column(quantity: str, order: int) -> str:
    """Name of a quantity's derivative in a file: r, rd, rdd; x_E, xd_E, xdd_E."""
    return quantity + "d" * order + ("" if quantity == "r" else "_E")


@dataclass(frozen=True)
class Rows:
    """What a file holds, in SI units: of each quantity (`r`, or `x` and `lam` or `phi`) its values
    (rows, size) and as many derivatives as are given; payload (rows,) [kg]; lines (rows,) of the
    file."""

    path: Path
    kind: Kind
    time: Array
    of: Mapping[str, Sequence[Array]]
    payload: Array
    lines: Sequence[int]

    def error(self, row: int, text: str) -> TrajectoryError:
        """An error about a row, which names its line and its time."""
        return TrajectoryError(
            f"{self.path}: line {self.lines[row]} (t = {self.time[row]:.9g} s): {text}"
        )


def read_rows(path: Path) -> Rows:
    """Read a trajectory file. TrajectoryError says what is wrong in which line."""
    try:
        with path.open("rb") as file:
            header = read_header(file, str(path))
            file.seek(0)
            before = file.read(header.start).count(b"\n")
            text = decode(file.read())
    except OSError as error:
        raise TrajectoryError(unreadable(path, error)) from None
    table, lines = _numbers(path, header, text, before + 1)
    scaled = _scaled(path, header, table)
    time = scaled.pop("time")[:, 0]
    payload = scaled.pop("payload", np.zeros((len(time), 1)))[:, 0]
    kind, of = _derivatives(path, scaled)
    rows = Rows(path, kind, time, of, payload, lines)
    if len(time) < 2:
        raise TrajectoryError(f"{path}: {len(time)} rows of numbers: a motion has at least two")
    for k in np.flatnonzero(np.diff(time) <= 0)[:1] + 1:
        raise rows.error(int(k), f"time must rise, the row before is at {time[k - 1]:.9g} s")
    for k in np.flatnonzero((payload < 0) | (payload > MAX_PAYLOAD))[:1]:
        raise rows.error(int(k), f"payload {payload[k]:g} kg, allowed 0 to {MAX_PAYLOAD:g} kg")
    return rows


def _numbers(path: Path, header: Header, text: str, first: int) -> tuple[Array, list[int]]:
    """All numbers (rows, columns) and the line of each row; `text` begins at line `first`."""
    rows, lines, names = [], [], header.names
    for number, line in enumerate(text.splitlines(), start=first):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        fields = line.split(header.separator)
        if len(fields) != len(names):
            raise TrajectoryError(
                f"{path}: line {number}: {len(fields)} fields, {len(names)} names in the first row"
            )
        rows.append([_number(path, number, *pair) for pair in zip(names, fields, strict=True)])
        lines.append(number)
        if len(rows) > MOST_ROWS:
            raise TrajectoryError(
                f"{path}: more than {MOST_ROWS} rows: leave rows out, what is between them is"
                " interpolated smoothly"
            )
    return np.array(rows, dtype=float).reshape(len(rows), len(names)), lines


def _number(path: Path, line: int, name: str, field: str) -> float:
    try:
        value = float(field.strip(' "'))
    except ValueError:
        value = float("nan")
    if not np.isfinite(value):
        raise TrajectoryError(f"{path}: line {line}: {name} is {field.strip()!r}, no finite number")
    return value


def _scaled(path: Path, header: Header, table: Array) -> dict[str, Array]:
    """Columns by array name in SI units, each whole."""
    if len(header.units) != len(header.names):
        raise TrajectoryError(
            f"{path}: {len(header.units)} units for {len(header.names)} names: the second row gives"
            " the unit of each column, as in s,rad,rad"
        )
    single = {"time": TIME, "payload": {"kg": 1.0, "g": 1e-3}}
    known = {name: (name, name, units) for name, units in single.items()} | {
        column(name, order) + element: (column(name, order), element, units)
        for name, orders in DERIVATIVES.items()
        for order, units in enumerate(orders)
        for element in SUFFIXES[name]
    }
    scaled: dict[str, dict[str, Array]] = {}
    for k, (name, unit) in enumerate(zip(header.names, header.units, strict=True)):
        if name not in known:
            raise TrajectoryError(
                f"{path}: unknown column {name!r}: a trajectory has time, payload, and {WANTED},"
                " rates rd, xd_E ..., accelerations rdd, xdd_E ..."
            )
        array, element, units = known[name]
        plain = unit.replace("^", "").replace("²", "2")
        if plain not in units:
            raise TrajectoryError(
                f"{path}: column {name}: unit {unit!r}, must be one of {', '.join(units)}"
            )
        if element in scaled.setdefault(array, {}):
            raise TrajectoryError(f"{path}: column {name} stands twice")
        scaled[array][element] = units[plain] * table[:, k]
    if "time" not in scaled:
        raise TrajectoryError(f"{path}: has no column time")
    whole = {array: [e for a, e, _ in known.values() if a == array] for array in scaled}
    for array, elements in whole.items():
        for element in elements:
            if element not in scaled[array]:
                raise TrajectoryError(f"{path}: column {array}{element} is missing")
    return {a: np.column_stack([scaled[a][e] for e in elements]) for a, elements in whole.items()}


def _derivatives(path: Path, columns: Mapping[str, Array]) -> tuple[Kind, dict[str, list[Array]]]:
    """Which kind of motion it is, and of each quantity as many derivatives."""
    quantities = tuple(name for name in SUFFIXES if column(name, 0) in columns)
    if quantities not in KINDS:
        raise TrajectoryError(
            f"{path}: has columns of {' and '.join(quantities) or 'no motion'}: must be {WANTED}"
            " (zeros where the platform stays level)"
        )
    orders = max(o for o in range(3) if any(column(q, o) in columns for q in quantities)) + 1
    wanted = [column(q, order) for q in quantities for order in range(orders)]
    for name in wanted:
        if name not in columns:
            raise TrajectoryError(f"{path}: has no {name}, which goes with the other rates")
    for name in sorted(set(columns) - set(wanted)):
        raise TrajectoryError(f"{path}: has {name} without the values that it is the rate of")
    of = {q: [columns[column(q, order)] for order in range(orders)] for q in quantities}
    return KINDS[quantities], of

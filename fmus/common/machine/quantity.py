"""Quantities of a machine file: a value with its unit and its provenance.

    m = { value = 0.5, unit = "kg", source = "assumed", note = "weighed without screws" }

`Annotated[float, quantity("kg", gt=0)]` is a pydantic field that reads such a table,
refuses another unit, NaN, a wrong shape or a value out of range, and leaves the plain
number (or tuple).
"""

from __future__ import annotations

import difflib
import math
from dataclasses import dataclass, field
from typing import Any

from pydantic import BeforeValidator

SOURCES = ("published", "derived", "assumed", "measured", "fitted", "diagnosed")
_KEYS = {"value", "unit", "source", "note", "ci95"}


@dataclass(frozen=True)
class Quantity(BeforeValidator):
    """A reader with the unit that it wants; bare: a number alone will do."""

    unit: str = field(default="", kw_only=True)
    bare: bool = field(default=False, kw_only=True)


def quantity(
    unit: str,
    *shape: int,
    gt: float | None = None,
    ge: float | None = None,
    le: float | None = None,
    bare: bool = False,
) -> Quantity:
    """Reader of a quantity in `unit`, for `Annotated[float, quantity("kg", gt=0)]`.

    shape: () for a number, (3,) for a vector, (6, 9) for a matrix; a length of -1 is free.
    gt, ge, le: bounds in `unit` for every element. bare: the value may stand alone, or without a
    source. Errors are ValueError, which pydantic turns into a message that names the field.
    """

    def read(table: Any) -> Any:
        if bare:
            given = table if isinstance(table, dict) else {"value": table, "unit": unit}
            table = {"source": "assumed", **given}
        form = f'wants {{ value = ..., unit = "{unit}", source = "..." }}'
        if not isinstance(table, dict):
            raise ValueError(f"{form}, is {table!r}")
        unknown = sorted(set(table) - _KEYS)
        if unknown:
            near = difflib.get_close_matches(unknown[0], _KEYS, n=1)
            hint = f"did you mean {near[0]}?" if near else f"allowed: {', '.join(sorted(_KEYS))}"
            raise ValueError(f"unknown key {unknown[0]!r}, {hint}")
        lacking = [key for key in ("value", "unit", "source") if key not in table]
        if lacking:
            raise ValueError(f"{form}, {' and '.join(lacking)} missing")
        if table["unit"] != unit:
            raise ValueError(f"is in {table['unit']!r}, wanted {unit!r}: convert the value")
        if table["source"] not in SOURCES:
            raise ValueError(f"source {table['source']!r}, allowed: {', '.join(SOURCES)}")
        value = _shaped(table["value"], shape)
        for number in _flat(value):
            _check(number, unit, gt, ge, le)
        return value

    return Quantity(read, unit=unit, bare=bare)


def _shaped(value: Any, shape: tuple[int, ...]) -> Any:
    if not shape:
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise ValueError(f"value {value!r} is not a number")
        return float(value)
    if not isinstance(value, list):
        raise ValueError(f"wants a list of {_text(shape)} numbers, is {value!r}")
    if shape[0] not in (-1, len(value)):
        raise ValueError(f"wants {shape[0]} entries, has {len(value)}")
    return tuple(_shaped(entry, shape[1:]) for entry in value)


def _text(shape: tuple[int, ...]) -> str:
    return " x ".join("any" if n == -1 else str(n) for n in shape)


def _flat(value: Any) -> list[float]:
    if isinstance(value, float):
        return [value]
    return [number for entry in value for number in _flat(entry)]


def _check(number: float, unit: str, gt: float | None, ge: float | None, le: float | None) -> None:
    if not math.isfinite(number):
        raise ValueError(f"{number} is not a finite number")
    shown = "" if unit == "1" else f" {unit}"
    if gt is not None and not number > gt:
        raise ValueError(f"{number}{shown}, must be above {gt}{shown}")
    if ge is not None and not number >= ge:
        raise ValueError(f"{number}{shown}, must be at least {ge}{shown}")
    if le is not None and not number <= le:
        raise ValueError(f"{number}{shown}, must be at most {le}{shown}")

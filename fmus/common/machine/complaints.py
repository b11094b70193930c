"""What pydantic finds wrong with a machine file, in sentences: file, field, remedy."""

from __future__ import annotations

import difflib
import types
import typing
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from flexhex.fmus.common.machine.quantity import Quantity

Errors = Sequence[Any]
_PLAIN = {
    "int_type": "wants a whole number without point or quotes, is {}",
    "string_type": "wants a text in quotes, is {}",
    "bool_type": "wants true or false, is {}",
    "tuple_type": "wants a list, is {}",
    "model_type": "wants a table of keys, is {}",
    "dict_type": "wants a table of keys, is {}",
    "string_pattern_mismatch": "wants small letters, digits, - and _, a letter first, is {}",
}
_BOUNDS = {"greater_than_equal": ("at least", "ge"), "less_than_equal": ("at most", "le")}
_BOUNDS |= {"greater_than": ("above", "gt"), "less_than": ("below", "lt")}
SHOWN = 60
"""Characters of a wrong value that are shown."""


def complaints(path: str | Path, model: type[BaseModel], errors: Errors) -> list[str]:
    """A line for each mistake in the file of a model; a key that is missing because its name is
    misspelt is named once."""
    meant = {
        (*error["loc"][:-1], near)
        for error in errors
        if error["type"] == "extra_forbidden" and (near := _near(model, error["loc"]))
    }
    missing = {error["loc"] for error in errors if error["type"] == "missing"}
    shown = [error for error in errors if error["loc"] not in meant & missing]
    return [f"{path}: {_where(error['loc'])}{_text(model, error)}" for error in shown]


def _where(loc: Sequence[str | int]) -> str:
    """`arms.1.axis: `; entries of lists count from 1."""
    where = ".".join(str(part + 1 if isinstance(part, int) else part) for part in loc)
    return f"{where}: " if where else ""


def _text(model: type[BaseModel], error: Any) -> str:
    kind, given = error["type"], _short(error.get("input"))
    if kind == "missing":
        return f"is missing{_remedy(model, error['loc'])}"
    if kind == "extra_forbidden":
        near = _near(model, error["loc"])
        hint = (
            f"did you mean {near}?" if near else f"allowed: {', '.join(_keys(model, error['loc']))}"
        )
        return f"is not a known key, {hint}"
    if kind in ("too_short", "too_long"):
        limits = error["ctx"]
        wanted = limits.get("min_length", limits.get("max_length"))
        return f"{limits['actual_length']} entries, {wanted} wanted"
    if kind in _BOUNDS:
        word, key = _BOUNDS[kind]
        return f"is {given}, must be {word} {error['ctx'][key]}"
    if kind == "tuple_type" and isinstance(error.get("input"), dict):
        return f"wants a list of tables: write [[{error['loc'][-1]}]]"
    if kind in _PLAIN:
        return _PLAIN[kind].format(given)
    return str(error["msg"]).removeprefix("Value error, ")


def _short(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= SHOWN else f"{text[:SHOWN]} ..."


def _near(model: type[BaseModel], loc: Sequence[str | int]) -> str:
    """The known key that a misspelt one is closest to, or nothing."""
    matches = difflib.get_close_matches(str(loc[-1]), _keys(model, loc), n=1)
    return matches[0] if matches else ""


def _keys(model: type[BaseModel], loc: Sequence[str | int]) -> list[str]:
    """Keys beside the last of `loc`."""
    section = _section(model, loc[:-1])
    return list(section.model_fields) if section else []


def _remedy(model: type[BaseModel], loc: Sequence[str | int]) -> str:
    """How to add a missing key: a quantity with its unit, or a table with its keys."""
    name, section = str(loc[-1]), _section(model, loc[:-1])
    field = section.model_fields.get(name) if section else None
    if field is None:
        return ""
    for read in (m for m in field.metadata if isinstance(m, Quantity)):
        if read.bare:
            return f": add {name} = ... [{read.unit}]"
        return f': add {name} = {{ value = ..., unit = "{read.unit}", source = "..." }}'
    below = _section(model, loc)
    if below is None:
        return f": add {name} = ..."
    heading = f"[{_where(loc)[:-2]}]"
    heading = f"[{heading}]" if typing.get_origin(field.annotation) is tuple else heading
    return f": add a table {heading} with {', '.join(below.model_fields)}"


def _section(model: type[BaseModel], loc: Sequence[str | int]) -> type[BaseModel] | None:
    """The model of the table at `loc`."""
    now: type[BaseModel] | None = model
    parts = iter([part for part in loc if isinstance(part, str)])
    for part in parts:
        field = now.model_fields.get(part) if now else None
        now = next(_models(field.annotation), None) if field else None
        if field and typing.get_origin(field.annotation) is dict:
            next(parts, None)  # the name of one of many tables
    return now


def _models(annotation: Any) -> Iterator[type[BaseModel]]:
    """Models within `X | None`, `tuple[X, ...]` and the like."""
    if isinstance(annotation, type) and not isinstance(annotation, types.GenericAlias):
        if issubclass(annotation, BaseModel):
            yield annotation
        return
    for part in typing.get_args(annotation):
        yield from _models(part)

"""modelDescription.xml of one of our own FMUs back to the `Interface` it was written from."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from typing import Any, Literal, cast

from lxml import etree

from flexhex.fmus.common.errors import InterfaceError
from flexhex.fmus.common.interface import (
    Causality,
    Interface,
    Item,
    Type,
    Variable,
    array_of,
    indices,
    value_of,
)

_OWN = {"Ts", "fault"}
"""Every interface adds these by itself."""


def interface_of(description: bytes, where: str) -> Interface:
    """The interface, without the constants of its C header.

    Raises InterfaceError when the text is none of fmugen's.
    """
    try:
        root = etree.fromstring(description)
    except etree.XMLSyntaxError as error:
        raise InterfaceError(f"{where}: not valid XML: {error.msg}") from None
    if str(root.get("generationTool")).partition(" ")[0] != "flexhex":
        raise InterfaceError(f"{where}: written by {root.get('generationTool')!r}, not by flexhex")
    scalars = list(root.iterfind("ModelVariables/ScalarVariable"))
    sources = _initial_sources(root, [s.get("name", "") for s in scalars])
    groups = itertools.groupby(scalars, key=lambda s: array_of(s.get("name", "")))
    types = _items(root)
    listed = [_variable(name, list(parts), sources, types) for name, parts in groups]
    Ts = next(v for v in listed if v.name == "Ts")
    variables = tuple(v for v in listed if v.name not in _OWN)
    faults = next(v for v in listed if v.name == "fault").items[2:]
    name, text = root.get("modelName", ""), root.get("description", "")
    return Interface(name, text, Ts.starts[0], variables, faults=faults)


def _items(root: Any) -> dict[str, tuple[Item, ...]]:
    """Items of the enumerations by the name of their type."""
    return {
        simple.get("name"): tuple(
            Item(item.get("name"), item.get("description", ""))
            for item in simple.iterfind("Enumeration/Item")
        )
        for simple in root.iterfind("TypeDefinitions/SimpleType")
    }


def _initial_sources(root: Any, names: Sequence[str]) -> dict[str, tuple[str, ...]]:
    """Output -> what its first value comes from, without indices."""
    sources: dict[str, dict[str, None]] = {}
    for unknown in root.iterfind("ModelStructure/InitialUnknowns/Unknown"):
        states = sources.setdefault(array_of(names[int(unknown.get("index")) - 1]), {})
        for index in (unknown.get("dependencies") or "").split():
            states[array_of(names[int(index) - 1])] = None
    return {name: tuple(states) for name, states in sources.items()}


def _variable(
    name: str,
    parts: Sequence[Any],
    sources: Mapping[str, tuple[str, ...]],
    types: Mapping[str, tuple[Item, ...]],
) -> Variable:
    reals = [part.find("*") for part in parts]
    first, real = parts[0], reals[0]
    suffixes = tuple(part.get("name", "").removeprefix(name) for part in parts)
    unlike = suffixes not in (("",), indices(len(parts)))
    is_array = suffixes != ("",)
    units = tuple(r.get("unit", "1") for r in reals)
    starts = [value_of(r.get("start", "0")) for r in reals]
    lows = tuple(float(r.get("min", -math.inf)) for r in reals)
    # where sizes differ they follow from the units
    nominal = real.get("nominal") if len({r.get("nominal") for r in reals}) == 1 else None
    return Variable(
        name,
        cast(Causality, first.get("causality")),
        units[0],
        first.get("description", ""),
        size=len(parts) if is_array else None,
        start=starts if is_array else starts[0],
        min=min(lows),
        max=float(real.get("max", math.inf)),
        nominal=None if nominal is None else float(nominal),
        variability=cast(Literal["fixed", "tunable", "discrete"], first.get("variability")),
        elements=tuple(s.removeprefix(".") for s in suffixes) if unlike else (),
        units=units if len(set(units)) > 1 else (),
        least=lows if len(set(lows)) > 1 else (),
        initial_from=sources.get(name, ()),
        display="" if len(set(units)) > 1 else real.get("displayUnit", ""),
        type=cast(Type, real.tag),
        items=types.get(real.get("declaredType", ""), ()),
    )

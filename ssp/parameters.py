"""Parameter sets of a .ssp (SSP 1.0): names, values, units, and their values in other units."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from flexhex.fmus.common.errors import InterfaceError
from flexhex.fmus.common.interface import value_of
from flexhex.ssp.fmu import Fmu, FmuVariable, listed
from flexhex.ssp.wiring import unknown
from flexhex.ssp.xml import NAMESPACES

Units = Mapping[str, Mapping[str, str]]
"""Unit by name: the attributes of its BaseUnit, exponents of SI units, `factor`, `offset`."""

Value = float | bool | str
"""Of a parameter: a number, a flag, the name of an enumeration's item."""


@dataclass(frozen=True)
class Setting:
    """One parameter of a set: its value in `unit`, which `units` defines; no unit: the FMU's.

    word: the name of an enumeration's item, `true` or `false`, whose value depends on what the
    FMU's variable is; value is NaN then.
    """

    name: str
    value: float
    unit: str
    units: Units
    word: str = ""

    def value_for(self, variable: FmuVariable, fmu: Fmu) -> float:
        """The value as an FMU's variable takes it, in its unit.

        InterfaceError when it cannot be converted: a unit that is not defined or is another
        quantity's, an item that the enumeration lacks, a fraction where a whole number is due.
        """
        if self.word and variable.type == "Enumeration":
            return _item(self.name, self.word, variable, fmu)
        if self.word:
            return number_for(self.name, self.word, variable, fmu)
        if wrong := variable.objection(self.value):
            raise InterfaceError(f"{self.name} = {wrong}")
        return self.value_in(variable.unit, fmu.units)

    def value_in(self, unit: str, units: Units) -> float:
        """The value in an FMU's unit, which the FMU's units define; InterfaceError as above."""
        if self.unit in ("", unit) or not unit:
            return self.value
        mine, theirs = self.units.get(self.unit), units.get(unit)
        is_so = f"{self.name} = {self.value:.9g} {self.unit}, the FMU wants {unit}"
        if mine is None or theirs is None:
            missing = self.unit if mine is None else unit
            raise InterfaceError(
                f"{is_so}, and no ssc:Unit says what {missing} is: write the value in {unit}"
            )
        if _exponents(mine) != _exponents(theirs):
            raise InterfaceError(f"{is_so}, which is another quantity")
        (factor, offset), (to_factor, to_offset) = _scale(mine), _scale(theirs)
        return (self.value * factor + offset - to_offset) / to_factor


def number_for(name: str, value: Value, variable: FmuVariable, fmu: Fmu) -> float:
    """A value that a user gave as an FMU's variable takes it, in its unit.

    Of a Boolean also True or "true", of an Enumeration also the name of an item. InterfaceError for
    what the variable's type does not take; name: for the message.
    """
    text = str(value).strip()
    is_flag = text.lower() in ("true", "false")
    if is_flag and variable.type == "Boolean":
        return float(text.lower() == "true")
    number = math.nan if is_flag else _number(text)
    if math.isnan(number) and variable.type == "Enumeration":
        return _item(name, text, variable, fmu)
    if not math.isfinite(number):
        kind = "0, 1, true or false" if variable.type == "Boolean" else "a finite number"
        raise InterfaceError(f"{name} = {text}, must be {kind}")
    if wrong := variable.objection(number):
        raise InterfaceError(f"{name} = {wrong}")
    items = fmu.enumerations.get(variable.declared_type)
    if items and number not in items.values():
        raise InterfaceError(f"{name} = {number:.9g}, must be one of {listed(items)}")
    return number


def _item(name: str, item: str, variable: FmuVariable, fmu: Fmu) -> float:
    items = fmu.enumerations.get(variable.declared_type, {})
    if item not in items:
        raise InterfaceError(f"{name}: {unknown('item', item, items)}")
    return float(items[item])


def settings(parameter_set: Any, units: Units, prefix: str = "") -> Iterator[Setting]:
    """Every parameter of a set; units: those defined outside it.

    InterfaceError for one that has no finite value.
    """
    known = {**units, **units_of(parameter_set.find("ssv:Units", NAMESPACES))}
    for entry in parameter_set.iterfind("ssv:Parameters/ssv:Parameter", NAMESPACES):
        name, typed = entry.get("name", ""), entry.find("*")
        text = "" if typed is None else typed.get("value", "")
        kind = "" if typed is None else typed.tag.partition("}")[2]
        if text and (kind == "Enumeration" or (kind == "Boolean" and text in ("true", "false"))):
            yield Setting(prefix + name, math.nan, "", known, text)
            continue
        value = _number(text)
        if not math.isfinite(value):
            raise InterfaceError(f"parameter {name!r} has no finite value: {text!r}")
        yield Setting(prefix + name, value, typed.get("unit", ""), known)


def units_of(element: Any) -> dict[str, dict[str, str]]:
    """Units that an element `Units` defines; None defines none."""
    if element is None:
        return {}
    return {
        unit.get("name", ""): {str(k): str(v) for k, v in base.attrib.items()}
        for unit in element.iterfind("ssc:Unit", NAMESPACES)
        for base in unit.iterfind("ssc:BaseUnit", NAMESPACES)
    }


def _number(text: str | None, otherwise: float = math.nan) -> float:
    try:
        return otherwise if text is None else value_of(text)
    except ValueError:
        return math.nan


def _scale(base: Mapping[str, str]) -> tuple[float, float]:
    return _number(base.get("factor"), 1.0), _number(base.get("offset"), 0.0)


def _exponents(base: Mapping[str, str]) -> dict[str, float]:
    """Without rad, which is a number too."""
    powers = {k: _number(v) for k, v in base.items() if k not in ("factor", "offset", "rad")}
    return {k: power for k, power in powers.items() if power}

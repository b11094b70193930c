"""What an FMU shows: variables with unit and range, sample time, constants, faults.

The `interface.py` of an FMU's folder builds one `Interface` for a machine; `fmugen` turns it into
modelDescription.xml, C structs and value references. Names are scalar (`fault`) or arrays: `theta`
is `theta[1]` ... in FMI and SSP, `theta[0]` ... in C; where the elements of an array are unlike
things, FMI and SSP name each (`x_E.x`, `p.actuator[1].a[3]`) and C counts on.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from flexhex.fmus.common.errors import InterfaceError, StartValueError

Causality = Literal["parameter", "input", "output"]
Variability = Literal["fixed", "tunable", "discrete"]
Type = Literal["Real", "Integer", "Boolean", "Enumeration"]
Start = float | Sequence[float] | NDArray[np.float64]
_NAME = re.compile(r"[a-zA-Z_][a-zA-Z0-9_]*")
_ARRAY = re.compile(r"[^.\[]*")
_WORD = r"(?:[A-Za-z_]\w*|'(?:[^'\\]|\\.)+')(?:\[\d+(?:,\d+)*\])?"
STRUCTURED = re.compile(rf"{_WORD}(?:\.{_WORD})*|der\({_WORD}(?:\.{_WORD})*(?:,\d+)?\)", re.ASCII)
"""Names of the convention `structured` (FMI 2.0, section 2.2.9)."""


class Item(NamedTuple):
    """One value of an enumeration, counted from 0; name: an identifier, as tools make one of it."""

    name: str
    description: str


def indices(size: int) -> tuple[str, ...]:
    """`[1]` ... `[size]`."""
    return tuple(f"[{k}]" for k in range(1, size + 1))


def value_of(text: str) -> float:
    """A value of any type as FMI writes it: `0.5`, `2`, `true`. ValueError for another text."""
    text = text.strip()
    return float(text == "true") if text in ("true", "false") else float(text)


def written(type_: str, value: float) -> str:
    """The inverse: a value as FMI and SSP write it for a type; an enumeration's is a number."""
    if type_ == "Real":
        return repr(float(value))
    return str(bool(value)).lower() if type_ == "Boolean" else str(round(value))


def array_of(name: str) -> str:
    """`p` of `p.actuator[1].o`, `theta` of `theta[3]`: all before the first dot or bracket."""
    return _ARRAY.match(name)[0]  # type: ignore[index]


@dataclass(frozen=True)
class Variable:
    """One FMU variable, or one array of them (size given).

    start [unit] is one value for all elements or one per element. min, max [unit]
    hold for every element; a value outside them is refused by the FMU. elements and units
    name and measure each element where an array holds unlike things: `actuator[1].o` of p is
    `p.actuator[1].o`, `[1].o` of actuator is `actuator[1].o`; units then overrules `unit`, and
    least, a bound of each, `min`.
    initial_from: parameters from which an output's first value comes, element by element where
    sizes agree. display: the unit that people read it in, when it is not the usual one of its
    unit. nominal [unit]: its ordinary size. type: that of FMI; in C everything is a double. items:
    the values of an Enumeration.

    Raises InterfaceError for a name that is no C identifier, an element's that is no structured
    name of FMI or there twice, a wrong number of start values, StartValueError for one outside
    min..max.
    """

    name: str
    causality: Causality
    unit: str
    description: str
    size: int | None = None
    start: Start = 0.0
    min: float = -math.inf
    max: float = math.inf
    nominal: float | None = None
    variability: Variability = "discrete"
    elements: tuple[str, ...] = ()
    units: tuple[str, ...] = ()
    least: tuple[float, ...] = ()
    initial_from: tuple[str, ...] = ()
    display: str = ""
    type: Type = "Real"
    items: tuple[Item, ...] = ()

    def __post_init__(self) -> None:
        if not _NAME.fullmatch(self.name):
            raise InterfaceError(f"variable {self.name!r}: not a C identifier")
        if self.causality == "parameter" and self.variability == "discrete":
            object.__setattr__(self, "variability", "fixed")
        if self.least and len(self.least) != self.count:
            raise InterfaceError(f"{self.name}: {len(self.least)} bounds for {self.count} elements")
        last = {"Boolean": 1.0, "Enumeration": len(self.items) - 1.0}.get(self.type)
        if last is not None:
            object.__setattr__(self, "min", 0.0)
            object.__setattr__(self, "max", last)
        for k, value in enumerate(self.starts):
            if not self.lows[k] <= value <= self.max:
                unit = self.units[k] if self.units else self.unit
                raise StartValueError(self.scalar_names[k], value, (self.lows[k], self.max), unit)
            if self.type != "Real" and value != round(value):
                name = self.scalar_names[k]
                raise InterfaceError(f"{name} starts at {value:.9g}, must be a whole number")
        for what, texts in (("names", self.elements), ("units", self.units)):
            if texts and len(texts) != self.count:
                raise InterfaceError(
                    f"{self.name}: {len(texts)} {what} of elements, {self.count} elements"
                )
        for name in self.scalar_names:
            if not STRUCTURED.fullmatch(name):
                raise InterfaceError(f"{name!r}: no structured name like arm[3].lam_Q[1]")
        if len(set(self.elements)) < len(self.elements):
            raise InterfaceError(f"{self.name}: an element's name is there twice")

    @property
    def count(self) -> int:
        """Number of scalar FMI variables."""
        return 1 if self.size is None else self.size

    @cached_property
    def starts(self) -> tuple[float, ...]:
        """Start value of every element [unit]."""
        if isinstance(self.start, (int, float)):
            return (float(self.start),) * self.count
        starts = tuple(float(value) for value in self.start)
        if len(starts) != self.count:
            raise InterfaceError(f"{self.name}: {len(starts)} start values for {self.count}")
        return starts

    @property
    def lows(self) -> tuple[float, ...]:
        """Least value of every element [unit]."""
        return self.least or (self.min,) * self.count

    @cached_property
    def scalar_names(self) -> tuple[str, ...]:
        """FMI names: `fault`, `theta[1]` ... `theta[6]`, or `x_E.x`, `x_E.y`, `x_E.z`."""
        return tuple(f"{self.name}{suffix}" for suffix in self.suffixes)

    @cached_property
    def suffixes(self) -> tuple[str, ...]:
        """What follows the array's name in those of its elements: `[1]`, `.x`."""
        if self.size is None:
            return ("",)
        if not self.elements:
            return indices(self.size)
        return tuple(e if e.startswith("[") else f".{e}" for e in self.elements)


@dataclass(frozen=True)
class Interface:
    """One FMU: `name` is its modelIdentifier, `Ts` its sample time [s].

    `constants` become #defines of the generated header, prefixed with the folder's
    name in capitals. Every interface gets the parameter `Ts` and the output `fault`; faults:
    its values from 2 on.
    """

    name: str
    description: str
    Ts: float
    variables: tuple[Variable, ...]
    constants: Mapping[str, int] = field(default_factory=dict)
    faults: tuple[Item, ...] = ()

    def __post_init__(self) -> None:
        names = [v.name for v in self.variables]
        twice = sorted({n for n in names if names.count(n) > 1})
        if twice:
            raise InterfaceError(f"{self.name}: declared twice: {', '.join(twice)}")
        reserved = sorted({"Ts", "fault"} & set(names))
        if reserved:
            raise InterfaceError(f"{self.name}: {', '.join(reserved)} is added by itself")

    @cached_property
    def parameters(self) -> tuple[Variable, ...]:
        """Parameters in value-reference order; `Ts` [s] comes first."""
        text = "sample time"
        Ts = Variable("Ts", "parameter", "s", text, None, self.Ts, 1e-6, 10.0, display="ms")
        return (Ts, *self._of("parameter"))

    @cached_property
    def inputs(self) -> tuple[Variable, ...]:
        """Inputs in value-reference order (after the parameters)."""
        return self._of("input")

    @cached_property
    def outputs(self) -> tuple[Variable, ...]:
        """Outputs in value-reference order (after the inputs); `fault` comes last."""
        items = (*_FAULTS, *self.faults)
        fault = Variable("fault", "output", "1", "what is wrong", type="Enumeration", items=items)
        return (*self._of("output"), fault)

    def _of(self, causality: Causality) -> tuple[Variable, ...]:
        return tuple(v for v in self.variables if v.causality == causality)


_FAULTS = (Item("none", "all is well"), Item("refused", "refused input or call"))
"""Values 0 and 1 of every `fault`."""


def flag(name: str, causality: Causality, description: str, start: Start, **more: Any) -> Variable:
    """A Boolean; start is 0 or 1."""
    return Variable(name, causality, "1", description, start=start, type="Boolean", **more)


def count(name: str, description: str, start: int, low: int, high: int) -> Variable:
    """A parameter that is a whole number."""
    return parameter(name, "1", description, start, low, high, type="Integer")


def parameter(
    name: str, unit: str, description: str, start: Start, low: float, high: float, **more: Any
) -> Variable:
    """A parameter that is fixed unless `more` says otherwise; low, high [unit]: its range."""
    return Variable(name, "parameter", unit, description, start=start, min=low, max=high, **more)

"""Wires between scalar ports, and the checks that every wiring must pass before it runs.

Used for a `System` that is being written and for a .ssp that is being read.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

from flexhex.fmus.common.errors import InterfaceError


class Port(NamedTuple):
    """One scalar FMU variable as a wiring sees it; causality and type as in FMI, unit by name."""

    causality: str
    unit: str
    type: str = "Real"


class Wire(NamedTuple):
    """One scalar connection: `source.output` feeds `target.input`."""

    source: str
    output: str
    target: str
    input: str

    def __str__(self) -> str:
        return f"{self.source}.{self.output} -> {self.target}.{self.input}"


Ports = Mapping[str, Mapping[str, Port]]
_INDEXED = re.compile(r"(\w+)\[(\d+)\]")


def whole_steps(name: str, Ts: float, base: float) -> int:
    """Number of base steps in the sample time Ts [s].

    Raises InterfaceError when that is no whole number >= 1. The tolerance, 1e-6 of a base
    step, is far above the rounding of a decimal fraction and far below half a step.
    """
    steps = Ts / base
    if not (0.5 < steps < 2**31) or abs(steps - round(steps)) > 1e-6:
        raise InterfaceError(
            f"{name}: Ts = {Ts:.9g} s is {steps:.6g} base steps of {base:.9g} s,"
            " must be a whole number: change Ts or the base step"
        )
    return round(steps)


def check_wires(wires: Sequence[Wire], ports: Ports, *, all_fed: bool = True) -> None:
    """Raise InterfaceError for the first wiring mistake.

    Unknown component or variable, a wire that starts at no output or ends at no input,
    unequal units, an input fed twice and, when all_fed, an input fed by nothing.
    """
    fed: dict[tuple[str, str], Wire] = {}
    for wire in wires:
        start = _port(wire, wire.source, wire.output, ports)
        end = _port(wire, wire.target, wire.input, ports)
        _check_direction(wire, start, end)
        if start.type != end.type:
            raise InterfaceError(
                f"connection {wire}: {start.type} into {end.type}, must be equal: connect another"
                " variable"
            )
        if start.unit != end.unit:
            raise InterfaceError(
                f"connection {wire}: {start.unit or 'no unit'} into {end.unit or 'no unit'},"
                " must be equal: connect another variable or correct a unit"
            )
        other = fed.setdefault((wire.target, wire.input), wire)
        if other is not wire:
            raise InterfaceError(
                f"{wire.target}.{wire.input} is fed by {other.source}.{other.output} and by"
                f" {wire.source}.{wire.output}: keep one connection"
            )
    if all_fed:
        _check_fed(fed.keys(), ports)


def renamed(name: str, known: Iterable[str]) -> str:
    """`p.actuator[1].d` for `p[3]`, where the elements of p have names; empty for other names.

    known: in the order of the model description, by which elements were counted before.
    """
    if not (match := _INDEXED.fullmatch(name)):
        return ""
    starts, k = (f"{match[1]}.", f"{match[1]}["), int(match[2])
    elements = [other for other in known if other.startswith(starts)]
    return elements[k - 1] if 1 <= k <= len(elements) and name not in elements else ""


def unknown(what: str, name: str, known: Iterable[str]) -> str:
    """Text for a name that does not exist, with its new name or the nearest ones that do."""
    names = list(known)
    if new := renamed(name, names):
        return f"there is no {what} {name!r}, it is called {new!r}"
    near = difflib.get_close_matches(name, names, n=1, cutoff=0.5)
    if near:
        return f"there is no {what} {name!r}, did you mean {near[0]!r}?"
    shown = ", ".join(names[:12]) + (", ..." if len(names) > 12 else "")
    return f"there is no {what} {name!r}, there are {shown or 'none'}"


def _port(wire: Wire, component: str, variable: str, ports: Ports) -> Port:
    if component not in ports:
        raise InterfaceError(f"connection {wire}: {unknown('component', component, ports)}")
    if variable not in ports[component]:
        text = unknown("variable", variable, ports[component])
        raise InterfaceError(f"connection {wire}: in {component} {text}")
    return ports[component][variable]


def _check_direction(wire: Wire, start: Port, end: Port) -> None:
    if start.causality != "output":
        raise InterfaceError(
            f"connection {wire}: {wire.source}.{wire.output} is of causality"
            f" {start.causality}; a connection starts at an output"
        )
    if end.causality != "input":
        raise InterfaceError(
            f"connection {wire}: {wire.target}.{wire.input} is of causality"
            f" {end.causality}; a connection ends at an input"
        )


def _check_fed(fed: Iterable[tuple[str, str]], ports: Ports) -> None:
    have = set(fed)
    for component, variables in ports.items():
        missing = [
            name
            for name, port in variables.items()
            if port.causality == "input" and (component, name) not in have
        ]
        if missing:
            more = f" and {len(missing) - 1} more" if len(missing) > 1 else ""
            raise InterfaceError(
                f"{component}.{missing[0]}{more}: fed by nothing; connect an output to it"
            )

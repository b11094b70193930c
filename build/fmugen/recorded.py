"""Reference results inside an FMU: what its own binary answered when it was built.

    resources/reference_in.csv    time and inputs before each step
    resources/reference_out.csv   time and outputs after it

The inputs wander a little about their start values, from a rule that any language can repeat.
"""

from __future__ import annotations

import ctypes as ct
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from flexhex.fmugen.sources import variables
from flexhex.fmus.common.errors import BuildError
from flexhex.fmus.common.interface import Interface, Variable

IN, OUT = "resources/reference_in.csv", "resources/reference_out.csv"
TICKS = 20
"""Steps of Ts that are recorded."""
STRIDE = 600
"""Ts in a step of an FMU without inputs: the reference stands still for its first seconds."""
Place = tuple[str, int]
"""Type and value reference of a variable."""
TYPES: dict[str, tuple[str, Any]] = {
    "Real": ("Real", ct.c_double),
    "Integer": ("Integer", ct.c_int),
    "Enumeration": ("Integer", ct.c_int),
    "Boolean": ("Boolean", ct.c_int),
}
"""FMI's functions for a type, and what they pass."""
_Logger = ct.CFUNCTYPE(None, ct.c_void_p, ct.c_char_p, ct.c_int, ct.c_char_p, ct.c_char_p)


class _Callbacks(ct.Structure):
    _fields_ = (
        ("logger", _Logger),
        ("allocate", ct.c_void_p),
        ("free", ct.c_void_p),
        ("finished", ct.c_void_p),
        ("environment", ct.c_void_p),
    )


def inputs(interface: Interface, step: int) -> list[float]:
    """Inputs [their units] before the step: within a thousandth of an ordinary size."""
    return [
        _value(v, start, (7 * step + 3 * k) % 11 - 5)
        for v in interface.inputs
        for k, start in enumerate(v.starts)
    ]


def _value(v: Variable, start: float, turn: int) -> float:
    width = min(v.max - v.min, 1.0)
    return min(max(start + 1e-3 * width * turn, v.min), v.max)


def recorded(interface: Interface, library: Path, guid: str) -> dict[str, bytes]:
    """Both files; none when the binary refuses its own start values, as its user will hear."""
    listed = variables(interface)
    names: dict[str, list[str]] = {"input": [], "output": [], "parameter": []}
    references: dict[str, list[Place]] = {"input": [], "output": [], "parameter": []}
    reference = 0
    for variable in listed:
        names[variable.causality] += variable.scalar_names
        places = range(reference, reference + variable.count)
        references[variable.causality] += [(variable.type, place) for place in places]
        reference += variable.count
    rows = [inputs(interface, k) for k in range(TICKS)]
    step = interface.Ts * (1 if interface.inputs else STRIDE)
    try:
        answers = _play(library, guid, step, references["input"], references["output"], rows)
    except BuildError:
        return {}
    before = [[k * step, *row] for k, row in enumerate(rows)]
    after = [[(k + 1) * step, *row] for k, row in enumerate(answers)]
    return {IN: _csv(names["input"], before), OUT: _csv(names["output"], after)}


def _csv(names: Sequence[str], rows: Sequence[Sequence[float]]) -> bytes:
    lines = [",".join(["time", *names]), *(",".join(map(repr, row)) for row in rows)]
    return ("\n".join(lines) + "\n").encode()


def _play(
    library: Path,
    guid: str,
    step: float,
    into: Sequence[Place],
    out: Sequence[Place],
    rows: Sequence[Sequence[float]],
) -> list[list[float]]:
    said: list[str] = []
    logger = _Logger(lambda _, __, ___, ____, text: said.append(text.decode()))
    callbacks, loaded = _Callbacks(logger), ct.CDLL(str(library))
    loaded.fmi2Instantiate.restype = ct.c_void_p
    c = loaded.fmi2Instantiate(b"recorded", 1, guid.encode(), None, ct.byref(callbacks), 0, 0)

    def call(function: str, *arguments: object) -> None:
        if c is None or loaded[function](ct.c_void_p(c), *arguments) > 1:
            raise BuildError(f"{library.stem}: {function} is refused: {' '.join(said[-1:])}")

    def exchange(verb: str, places: Sequence[Place], values: list[float]) -> None:
        for kind, (suffix, number) in TYPES.items():
            mine = [k for k, (type_, _) in enumerate(places) if type_ == kind]
            vr = (ct.c_uint * len(mine))(*(places[k][1] for k in mine))
            plain = float if number is ct.c_double else int
            passed = (number * len(mine))(*(plain(values[k]) for k in mine))
            call(f"fmi2{verb}{suffix}", vr, ct.c_size_t(len(mine)), passed)
            for k, value in zip(mine, passed, strict=True):
                values[k] = float(value)

    call("fmi2SetupExperiment", 0, ct.c_double(0), ct.c_double(0), 0, ct.c_double(0))
    call("fmi2EnterInitializationMode")
    call("fmi2ExitInitializationMode")
    answers = []
    for k, row in enumerate(rows):
        exchange("Set", into, list(row))
        call("fmi2DoStep", ct.c_double(k * step), ct.c_double(step), 1)
        values = [0.0] * len(out)
        exchange("Get", out, values)
        answers.append(values)
    loaded.fmi2FreeInstance(ct.c_void_p(c))
    if not all(math.isfinite(value) for row in answers for value in row):
        raise BuildError(f"{library.stem}: outputs that are no numbers after ordinary steps")
    return answers

"""Build the FMU of a room for a machine, with other start values where wanted."""

from __future__ import annotations

import dataclasses
import importlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexhex import fmus
from flexhex.fmugen.codegen import SYMBOLIC
from flexhex.fmugen.fmu import build_fmu
from flexhex.fmus.common.errors import InterfaceError
from flexhex.fmus.common.interface import Interface
from flexhex.fmus.common.machine.machine import Machine

Starts = Mapping[str, float | Sequence[float] | NDArray[np.float64]]
ROOMS = ("reference", "kinematics", "feedforward", "feedback", "plant", "filter", "estimator")


def with_starts(interface: Interface, starts: Starts) -> Interface:
    """The interface with other start values of its parameters; InterfaceError for unknown names."""
    if "Ts" in starts:
        raise InterfaceError(
            f"{interface.name}: Ts is set by the machine file, not as a start value"
        )
    known = {v.name for v in interface.variables if v.causality == "parameter"}
    unknown = sorted(set(starts) - known)
    if unknown:
        raise InterfaceError(
            f"{interface.name} has no parameter {unknown[0]!r}; it has: {', '.join(sorted(known))}"
        )
    variables = tuple(
        dataclasses.replace(v, start=starts[v.name]) if v.name in starts else v
        for v in interface.variables
    )
    return dataclasses.replace(interface, variables=variables)


def room_interface(room: str, machine: Machine, starts: Starts | None = None) -> Interface:
    """Interface of a room for a machine, with start values replaced."""
    module: Any = importlib.import_module(f"flexhex.fmus.{room}.interface")
    with SYMBOLIC:
        return with_starts(module.interface(machine), starts or {})


def step_file(room: str) -> Path:
    """The hand-written step.c of a room."""
    return Path(fmus.__path__[0]) / room / "step.c"


def build_room(
    room: str,
    machine: Machine,
    out_dir: Path,
    starts: Starts | None = None,
    cache: Path | None = None,
    platforms: Sequence[str] = (),
) -> Path:
    """Build `out_dir/<room>.fmu`; starts: parameter name -> value(s) baked in as defaults."""
    module: Any = importlib.import_module(f"flexhex.fmus.{room}.equations")
    interface = room_interface(room, machine, starts)
    with SYMBOLIC:
        functions, base = module.functions(machine), machine.timing.base
    return build_fmu(interface, functions, step_file(room), out_dir, base, cache, platforms)


def machine_interface(machine: Machine, truth: Path) -> Interface:
    """Interface of machine.fmu; MachineError for a wrong truth file."""
    from flexhex.fmus.machine import truth as real

    with SYMBOLIC:
        return real.interface(machine, real.load_truth(truth))


def build_machine(
    machine: Machine,
    truth: Path,
    out_dir: Path,
    starts: Starts | None = None,
    cache: Path | None = None,
    platforms: Sequence[str] = (),
) -> Path:
    """Build `out_dir/machine.fmu`: the plant plus what the truth file hides."""
    from flexhex.fmus.machine import truth as real

    interface = with_starts(machine_interface(machine, truth), starts or {})
    with SYMBOLIC:
        functions = real.functions(machine, real.load_truth(truth))
    base = machine.timing.base
    own = {
        path.name: path.read_text(encoding="utf-8")
        for path in sorted(Path(fmus.__path__[0], "machine").glob("*.h"))
    }
    return build_fmu(interface, functions, step_file("plant"), out_dir, base, cache, platforms, own)

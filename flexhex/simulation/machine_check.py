"""Whether the FMUs of a machine can be made: everything but the compiling is done once.

A machine file that reads well can still ask for what an FMU refuses: a start value beyond its
range, a feedback that no lead filter gives, sample times that do not meet. `Builder.check` makes
all interfaces with the feedback's design and the schedule; here its complaints get their field.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from flexhex.fmugen.units import unit
from flexhex.fmus.common.errors import FlexhexError, InterfaceError, MachineError, StartValueError
from flexhex.fmus.common.interface import Interface
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.machine_file import load_machine
from flexhex.simulation.fields import refused

Product = TypeVar("Product")


def named(path: Path, make: Callable[[], Product], where: str = "") -> Product:
    """What `make` returns; its complaint as a MachineError with file, field, FMU (`where`)."""
    try:
        result = make()
        if isinstance(result, Interface):
            result.parameters  # noqa: B018 - Ts is added, and checked, only here
        return result
    except FlexhexError as error:
        text = str(error)
        if text.startswith(str(path)):
            raise
        if isinstance(error, StartValueError):
            is_truth = where == "machine"
            text = (
                f"in machine.fmu {text}" if is_truth else refused(load_machine(path), error, where)
            )
        elif not isinstance(error, MachineError):
            text = f"timing: {text}"
        raise MachineError(f"{path}: {text}") from None


def refuse_units(path: Path, machine: Machine) -> None:
    """MachineError with the file for an effect of one's own with a unit that FMUs do not have."""
    for use in machine.effects:
        units = [(one.name, one.unit) for one in use.effect.gains]
        units += [(one.name, one.unit) for one in use.effect.shapes]
        for name, text in units:
            try:
                unit(text, f"{path}: effects: {use.id}.{name}")
            except InterfaceError as error:
                raise MachineError(str(error)) from None


def doubts(machine: Machine) -> list[str]:
    """What is allowed in a machine file, and yet may be a mistake."""
    g = machine.gravity.g
    if g[2] <= 0:
        return []
    return [
        f"gravity.g = [{', '.join(f'{v:g}' for v in g)}] m/s2 points upward (z is up): the"
        " end-effector hangs below the motors. If the machine stands, change the sign of the"
        " third component"
    ]

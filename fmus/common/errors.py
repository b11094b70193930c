"""The few errors that flexhex raises for a user's mistake: what, where, how to mend it."""

from __future__ import annotations

import os
from pathlib import Path


class FlexhexError(Exception):
    """A mistake that the user can mend; `exit_code` is what the command line ends with."""

    exit_code = 2


class UsageError(FlexhexError):
    """A wrong command, option or combination of them."""

    exit_code = 2


class MachineError(FlexhexError):
    """A machine file that does not describe a machine."""

    exit_code = 3


class LogError(FlexhexError):
    """A measured or simulated log that cannot be read or does not hold what is needed."""

    exit_code = 3


class TrajectoryError(FlexhexError):
    """A trajectory file that cannot be read, or a motion that the machine cannot make."""

    exit_code = 3


class OutputError(FlexhexError):
    """A file or folder that cannot be written."""

    exit_code = 3


class InterfaceError(FlexhexError):
    """An interface or wiring that contradicts itself."""

    exit_code = 3


class StartValueError(InterfaceError):
    """A start value outside its variable's range.

    name: as FMI has it, `mechanism.end_effector.m`; value and limits (least, largest) in `unit`.
    """

    def __init__(self, name: str, value: float, limits: tuple[float, float], unit: str) -> None:
        written = f" {unit}".removesuffix(" 1")
        super().__init__(
            f"{name} starts at {value:.9g}{written},"
            f" allowed {limits[0]:.9g} to {limits[1]:.9g}{written}"
        )
        self.name, self.value, self.limits, self.unit = name, value, limits, unit


class BuildError(FlexhexError):
    """Code generation or compilation failed."""

    exit_code = 4


class RunError(FlexhexError):
    """An FMU refused a call while the system was running."""

    exit_code = 1


def unreadable(path: str | Path, error: OSError) -> str:
    """Why a file cannot be read, in the same words everywhere: `log.csv: no such file`."""
    if isinstance(error, FileNotFoundError):
        return f"{path}: no such file"
    if isinstance(error, IsADirectoryError):
        return f"{path}: is a folder: name a file in it"
    return f"{path}: cannot be read: {os.strerror(error.errno) if error.errno else error}"

"""Base models by name: the only place where the diagnosis knows which machines there are."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from flexhex.diagnosis.arm import RigidArmBase
from flexhex.diagnosis.arms import SCHUNK
from flexhex.diagnosis.axis import AxisBase
from flexhex.diagnosis.base import Base
from flexhex.diagnosis.hexapod import HexapodBase
from flexhex.diagnosis.logs import Log
from flexhex.fmus.common.errors import LogError, UsageError
from flexhex.fmus.common.machine_file import load_machine


def _hexapod(machine_file: Path | None, log: Log) -> Base:
    if machine_file is None:
        raise LogError("no machine file given: the hexapod needs one (--machine)")
    return HexapodBase(load_machine(machine_file))


def _axis(machine_file: Path | None, log: Log) -> Base:
    return AxisBase(log["theta"].width, log["theta"].ts, log.kinds)


def _schunk(machine_file: Path | None, log: Log) -> Base:
    return RigidArmBase(SCHUNK, log["theta"].ts)


BASES: Mapping[str, Callable[[Path | None, Log], Base]] = {
    "hexapod": _hexapod,
    "axis": _axis,
    "schunk": _schunk,
}


def base_of(name: str, machine_file: Path | None, log: Log) -> Base:
    """The base model called `name` for logs like this one. UsageError for an unknown name."""
    if name not in BASES:
        raise UsageError(f"no base model {name!r}: choose one of {', '.join(BASES)}")
    return BASES[name](machine_file, log)

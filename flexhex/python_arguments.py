"""Arguments of the Python interface checked before anything is read."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from math import isfinite
from pathlib import Path
from typing import TypeGuard, TypeVar

from flexhex.diagnosis.logs import Log, Options
from flexhex.diagnosis.logs.motor import Given, motor_option
from flexhex.fmus.common.errors import UsageError

File = str | Path
T = TypeVar("T")


def listed(name: str, logs: Sequence[Log | File]) -> list[Log | Path]:
    """Logs and paths of an argument. UsageError for a single one, and for anything else."""
    if isinstance(logs, str | Path | Log) or not isinstance(logs, Iterable):
        shown = "one log" if isinstance(logs, Log) else repr(logs if logs is None else str(logs))
        raise UsageError(f"{name} = {shown}: must be a list of logs or paths, [log]")
    for k, log in enumerate(items := list(logs)):
        if not isinstance(log, str | Path | Log):
            kind = type(log).__name__
            raise UsageError(
                f"{name}[{k}] is of type {kind}: must be a path, or what read_log gives"
            )
    return [log if isinstance(log, Log) else Path(log) for log in items]


def names(name: str, given: Sequence[str]) -> tuple[str, ...]:
    """Names of an argument. UsageError for a text alone, and for anything else."""
    if isinstance(given, str) or not isinstance(given, Iterable):
        raise UsageError(f"{name} = {given!r}: must be a list of names")
    for item in (items := tuple(given)):
        if not isinstance(item, str):
            raise UsageError(f"{name}: {item!r} is no name")
    return items


def text(name: str, given: object) -> str:
    """A name or a path. UsageError for anything else."""
    if not isinstance(given, str | Path):
        raise UsageError(f"{name} = {given!r}: must be a name or a path")
    return str(given)


def of_kind(name: str, given: object, kind: type[T]) -> T:
    """A result that another function gave. UsageError for anything else."""
    if not isinstance(given, kind):
        raise UsageError(
            f"{name} is of type {type(given).__name__}: must be a flexhex.{kind.__name__}"
        )
    return given


def numbers(name: str, given: Mapping[str, float] | None) -> Mapping[str, float]:
    """Numbers by name. UsageError for anything else."""
    for key, value in _pairs(name, given).items():
        if not isinstance(value, int | float) or isinstance(value, bool):
            raise UsageError(f"{name}[{key!r}] = {value!r}: must be a number")
    return given or {}


def reading(
    constant: float | Sequence[float] | None,
    units: Mapping[str, str] | None,
    rename: Mapping[str, str] | None,
    motor: Given | None = None,
) -> Options:
    """How logs are read. UsageError for what is no unit, no name, no constant or no motor."""
    for name, given in (("units", units), ("rename", rename)):
        for key, value in _pairs(name, given).items():
            if not isinstance(value, str):
                raise UsageError(f"{name}[{key!r}] = {value!r}: must be a text")
    constants = constant if constant is None or _positive(constant) else _each(constant)
    if not isinstance(motor, str | Mapping | None):
        raise UsageError(f"motor = {motor!r}: must be a text, 'R=1.2 K_t=0.05', or a dictionary")
    return Options(constants, units or {}, rename or {}, motor=motor_option(constants, motor))


def _positive(value: object) -> TypeGuard[float]:
    return isinstance(value, int | float) and isfinite(value) and value > 0


def _each(constants: object) -> tuple[float, ...]:
    """One for each axis. UsageError for what is none."""
    if isinstance(constants, str) or not isinstance(constants, Iterable):
        raise UsageError(f"torque_constant = {constants!r}: must be a number above zero")
    for value in (each := tuple(constants)):
        if not _positive(value):
            raise UsageError(f"torque_constant: {value!r} is no number above zero")
    return each


def _pairs(name: str, given: Mapping[str, object] | None) -> Mapping[str, object]:
    if given is not None and not isinstance(given, Mapping):
        raise UsageError(f"{name} = {given!r}: must be a dictionary")
    return given or {}

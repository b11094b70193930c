"""The result of a run: samples by rate, never merged, with what produced them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from flexhex.fmus.common.errors import LogError
from flexhex.fmus.common.interface import indices
from flexhex.ssp.wiring import renamed, unknown

FORMAT = "flexhex-result"
VERSION = 1
"""Mark of our files, and the version of their layout."""
Array = npt.NDArray[np.float64]
Meta = Mapping[str, str | int | float]


@dataclass(frozen=True)
class FmuTime:
    """Time spent in one FMU: all and the worst step [s], 0 where it was not measured; steps;
    warnings, the first in words."""

    seconds: float
    worst: float
    steps: int
    warnings: int
    warning: str = ""


@dataclass(frozen=True)
class Group:
    """Signals of one rate. period in base steps, base [s].

    signals: `plant.theta` (n, 6) or `plant.fault` (n,); row k is what others see at
    k period base steps. units, descriptions: by the same names; the unit of an array whose
    elements differ in it is theirs in order, separated by commas. elements: what follows the name
    of an array in those of its elements (`.x`), where that is not `[1]`, `[2]` ...
    """

    period: int
    base: float
    signals: Mapping[str, Array]
    units: Mapping[str, str] = field(default_factory=dict)
    descriptions: Mapping[str, str] = field(default_factory=dict)
    elements: Mapping[str, tuple[str, ...]] = field(default_factory=dict)

    @property
    def Ts(self) -> float:
        """Sample time [s]."""
        return self.period * self.base

    @property
    def rows(self) -> int:
        """Number of samples."""
        return len(next(iter(self.signals.values()))) if self.signals else 0

    @property
    def time(self) -> Array:
        """Time axis (n,) [s], from integer counts."""
        counts = np.arange(self.rows, dtype=np.int64) * self.period
        return np.asarray(counts * self.base, dtype=np.float64)

    def array(self, name: str) -> str:
        """The signal of that name, or that it is an element of; empty where there is none."""
        if name in self.signals:
            return name
        arrays = (signal for signal in self.signals if name.startswith(signal))
        return next((signal for signal in arrays if name in self.columns(signal)), "")

    def columns(self, signal: str) -> list[str]:
        """Names of its scalars: `plant.theta[1]` ..., `plant.x_E.x` ..., or the signal itself."""
        shape = self.signals[signal].shape
        if len(shape) == 1:
            return [signal]
        return [signal + element for element in self.elements.get(signal) or indices(shape[1])]

    def column_units(self, signal: str) -> list[str]:
        """Unit of each of its scalars."""
        units, count = self.units.get(signal, "").split(","), len(self.columns(signal))
        return units if len(units) == count else units[:1] * count

    def table(self, first: int, end: int) -> Array:
        """Rows first to end with the time in front, (rows, 1 + scalars)."""
        parts = [v[first:end].reshape(end - first, -1) for v in self.signals.values()]
        return np.hstack([self.time[first:end, None], *parts])


@dataclass(frozen=True)
class Result:
    """The outcome of a run: groups by rate name (`0.25ms`), times by component, provenance."""

    groups: Mapping[str, Group]
    times: Mapping[str, FmuTime] = field(default_factory=dict)
    duration: float = 0.0
    wall: float = 0.0
    meta: Meta = field(default_factory=dict)

    def __contains__(self, signal: str) -> bool:
        """Whether the run logged the signal, or the array that it is an element of."""
        return any(group.array(signal) for group in self.groups.values())

    def group(self, signal: str) -> Group:
        """The group that holds a signal or an array's element; LogError when none does."""
        for group in self.groups.values():
            if group.array(signal):
                return group
        names = [name for group in self.groups.values() for name in group.signals]
        component, _, name = signal.partition(".")
        columns = [c for g in self.groups.values() for array in g.signals for c in g.columns(array)]
        if new := renamed(name, [c.removeprefix(f"{component}.") for c in columns]):
            raise LogError(f"there is no signal {signal!r}, it is called '{component}.{new}'")
        raise LogError(f"{unknown('signal', signal, names)}: was it asked for in the run?")

    def __getitem__(self, signal: str) -> Array:
        """Samples of `plant.theta`, (n,) or (n, size), or of `plant.theta[2]`, (n,)."""
        group = self.group(signal)
        array = group.array(signal)
        values = group.signals[array]
        return values if signal == array else values[:, group.columns(array).index(signal)]

    def time(self, signal: str) -> Array:
        """Time axis of a signal (n,) [s]."""
        return self.group(signal).time


def rate_name(period: int, base: float) -> str:
    """Name of the group of one rate: `0.25ms`."""
    return f"{period * base * 1e3:.9g}ms"


def plain(value: object) -> str | int | float:
    """A value of the metadata as Python's own type."""
    own = value.item() if isinstance(value, np.generic) else value
    return own if isinstance(own, str | int | float) else str(own)

"""Which outputs a run logs, and how scalars form arrays again."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from flexhex.fmus.common.errors import UsageError
from flexhex.fmus.common.interface import indices
from flexhex.ssp.fmu import FmuVariable
from flexhex.ssp.read import Instance, Package
from flexhex.ssp.wiring import unknown

DEFAULT = "default"
# Large arrays that a run logs only when asked.
LARGE = {"x", "xd", "xdd", "chi_f", "p", "p_std"}


@dataclass(frozen=True)
class LoggedVariable:
    """A variable to log: `theta` with its scalars in order, or one scalar alone."""

    name: str
    scalars: tuple[FmuVariable, ...]

    @property
    def is_array(self) -> bool:
        """Whether its samples are rows of several values."""
        return self.scalars[0].name != self.name

    @property
    def unit(self) -> str:
        """The common unit, or the units of the elements separated by commas."""
        units = [v.unit if v.type == "Real" else "1" for v in self.scalars]
        return units[0] if len(set(units)) == 1 else ",".join(units)

    @property
    def elements(self) -> tuple[str, ...]:
        """What follows the array's name in those of its elements: `[1]`, `.actuator[1].o`."""
        return tuple(v.name.removeprefix(self.name) for v in self.scalars)


def arrays(variables: Iterable[FmuVariable]) -> dict[str, LoggedVariable]:
    """Variables by array name; the elements of an array become one, in order of their index."""
    members: dict[str, dict[str, FmuVariable]] = {}
    for variable in variables:
        members.setdefault(variable.array, {})[variable.name] = variable
    signals = {}
    for name, parts in members.items():
        indexed = [f"{name}{k}" for k in indices(len(parts))]
        order = indexed if set(indexed) == set(parts) else list(parts)
        signals[name] = LoggedVariable(name, tuple(parts[element] for element in order))
    return signals


def select(package: Package, wanted: Sequence[str] | None) -> dict[str, list[LoggedVariable]]:
    """Signals to log by component.

    wanted: `plant` (all its outputs), `plant.theta`, `plant.x_E.z`, `default` (all but the
    large arrays); None is `default`. Raises UsageError for a name that is no output.
    """
    chosen: dict[str, dict[str, LoggedVariable]] = {i.name: {} for i in package.instances}
    for text in [DEFAULT] if wanted is None else wanted:
        for instance, signal in _find(package, text):
            chosen[instance][signal.name] = signal
    return {name: list(signals.values()) for name, signals in chosen.items()}


def _find(package: Package, text: str) -> list[tuple[str, LoggedVariable]]:
    outputs = {i.name: arrays(_outputs(i)) for i in package.instances}
    if text == DEFAULT:
        return [(i, s) for i, all_ in outputs.items() for s in all_.values() if s.name not in LARGE]
    component, dot, name = text.partition(".")
    if component not in outputs:
        raise UsageError(f"signal {text!r}: {unknown('component', component, outputs)}")
    known = outputs[component]
    if not dot:
        return [(component, signal) for signal in known.values()]
    if name in known:
        return [(component, known[name])]
    for signal in known.values():
        for variable in signal.scalars:
            if variable.name == name:
                return [(component, LoggedVariable(name, (variable,)))]
    names = [*known, *(v.name for signal in known.values() for v in signal.scalars)]
    raise UsageError(f"signal {text!r}: in {component} {unknown('output', name, names)}")


def _outputs(instance: Instance) -> list[FmuVariable]:
    return [v for v in instance.fmu.of("output") if v.type != "String"]

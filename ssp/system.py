"""The loop as data: components, connections, base step; checked when it is made.

`hexapod(...)` is the control structure of [SH, Fig. 3]. `flexhex.ssp.write` turns a `System` into
a portable .ssp, `flexhex.ssp.delays` computes from it how old every signal is.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

from flexhex.fmus.common.errors import InterfaceError
from flexhex.fmus.common.interface import Interface, Variable
from flexhex.ssp.wiring import Port, Wire, check_wires, unknown, whole_steps

BASE_STEP = 0.00025
_NAME = re.compile(r"[a-zA-Z_][a-zA-Z0-9_]*")
Box = tuple[float, float, float, float]


@dataclass(frozen=True)
class Component:
    """One FMU instance; source is the file name of its FMU.

    box: x1, y1, x2, y2 in the diagram (x to the right, y up); x1 > x2 draws the inputs on
    the right.
    """

    name: str
    interface: Interface
    source: str = ""
    box: Box | None = None

    def __post_init__(self) -> None:
        if not _NAME.fullmatch(self.name):
            raise InterfaceError(f"component {self.name!r}: not a name like N_F or plant")
        if not self.source:
            object.__setattr__(self, "source", f"{self.interface.name}.fmu")

    @property
    def variables(self) -> tuple[Variable, ...]:
        """Parameters, inputs and outputs in value-reference order."""
        block = self.interface
        return (*block.parameters, *block.inputs, *block.outputs)

    def find(self, name: str) -> tuple[str, ...]:
        """Scalar names behind `theta` (the whole array) or `theta[3]`.

        Raises InterfaceError when the component has no such variable.
        """
        for variable in self.variables:
            if name == variable.name:
                return variable.scalar_names
            if name in variable.scalar_names:
                return (name,)
        known = [v.name for v in self.variables]
        raise InterfaceError(f"in {self.name} {unknown('variable', name, known)}")


@dataclass(frozen=True)
class System:
    """Components and connections, each `("reference.r", "N_F.theta")` or element by element.

    base [s]: the step of the schedule. plots: outputs that the .ssp lists though nothing is
    connected to them. paths: chains of components whose delay the .ssp declares.

    Raises InterfaceError for the first mistake: a name twice, a sample time that is not a
    whole number of base steps, an unknown name, unequal sizes or units, an input fed twice
    or by nothing, a connection that ends at an output.
    """

    name: str
    components: tuple[Component, ...]
    connections: tuple[tuple[str, str], ...]
    base: float = BASE_STEP
    plots: tuple[str, ...] = ()
    paths: tuple[tuple[str, ...], ...] = ()
    routes: Mapping[tuple[str, str], tuple[float, ...]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        names = [c.name for c in self.components]
        twice = sorted({n for n in names if names.count(n) > 1})
        if twice:
            raise InterfaceError(f"{self.name}: component {twice[0]!r} exists twice: rename one")
        for component in self.components:
            self.steps(component.name)
        check_wires(self.wires, self._ports)
        for plot in self.plots:
            self._endpoint(plot, f"plot {plot}")

    def component(self, name: str) -> Component:
        """The component of that name, or InterfaceError."""
        for component in self.components:
            if component.name == name:
                return component
        raise InterfaceError(unknown("component", name, (c.name for c in self.components)))

    def steps(self, name: str) -> int:
        """Sample time of a component in base steps."""
        return whole_steps(name, self.component(name).interface.Ts, self.base)

    @cached_property
    def wires(self) -> tuple[Wire, ...]:
        """The connections, scalar by scalar."""
        return tuple(wire for pair in self.connections for wire in self._expand(*pair))

    @cached_property
    def _ports(self) -> dict[str, dict[str, Port]]:
        return {c.name: _ports(c) for c in self.components}

    def _endpoint(self, text: str, where: str) -> tuple[str, tuple[str, ...]]:
        name, dot, variable = text.partition(".")
        if not dot:
            raise InterfaceError(f"{where}: {text!r} is no `component.variable`")
        try:
            return name, self.component(name).find(variable)
        except InterfaceError as error:
            raise InterfaceError(f"{where}: {error}") from None

    def _expand(self, start: str, end: str) -> list[Wire]:
        where = f"connection {start} -> {end}"
        source, outputs = self._endpoint(start, where)
        target, inputs = self._endpoint(end, where)
        if len(outputs) != len(inputs):
            raise InterfaceError(
                f"{where}: {len(outputs)} values into {len(inputs)}; connect arrays of one"
                " size or single elements like theta[3]"
            )
        return [Wire(source, o, target, i) for o, i in zip(outputs, inputs, strict=True)]


def unit_of(variable: Variable, index: int) -> str:
    """Unit of one element (index from 0), as an array may declare one for each; of Reals alone."""
    if variable.type != "Real":
        return ""
    return variable.units[index] if variable.units else variable.unit


def _ports(component: Component) -> dict[str, Port]:
    return {
        name: Port(variable.causality, unit_of(variable, k), variable.type)
        for variable in component.variables
        for k, name in enumerate(variable.scalar_names)
    }

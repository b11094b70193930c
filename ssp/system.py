"""The loop as data: components, connections, base step; checked when it is made.

`hexapod(...)` is the control structure of [SH, Fig. 3]. `ssp.write` turns a `System` into
a portable .ssp, `ssp.delays` computes from it how old every signal is.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

from fmus.common.errors import InterfaceError
from fmus.common.interface import Interface, Variable
from ssp.wiring import Port, Wire, check_wires, unknown, whole_steps

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
        room = self.interface
        return (*room.parameters, *room.inputs, *room.outputs)

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
    """Unit of one element (index from 0); an array may declare one unit for each."""
    return variable.units[index] if variable.units else variable.unit


def _ports(component: Component) -> dict[str, Port]:
    return {
        name: Port(variable.causality, unit_of(variable, k))
        for variable in component.variables
        for k, name in enumerate(variable.scalar_names)
    }


# name: room, box; [SH, Fig. 3]: the reference on the left, N_F and F above, C and P in the
# middle, and below, from right to left, W, N_E and K (with E).
_LAYOUT: dict[str, tuple[str, Box]] = {
    "reference": ("reference", (0, 160, 100, 240)),
    "N_F": ("kinematics", (180, 320, 280, 400)),
    "F": ("feedforward", (360, 320, 460, 400)),
    "feedback": ("feedback", (360, 160, 460, 240)),
    "plant": ("plant", (560, 160, 660, 240)),
    "W": ("filter", (660, 0, 560, 80)),
    "N_E": ("kinematics", (460, 0, 360, 80)),
    "K": ("estimator", (280, 0, 180, 80)),
}

_ROUTES: dict[tuple[str, str], tuple[float, ...]] = {
    ("reference", "N_F"): (140,),
    ("reference", "feedback"): (230,),
    ("reference", "plant"): (120, 130, 530),
    ("N_F", "F"): (320,),
    ("K", "F"): (160, 300, 340),
    ("F", "feedback"): (480, 282, 322),
    ("feedback", "plant"): (510,),
    ("plant", "feedback"): (690, 264, 342),
    ("plant", "W"): (690,),
    ("W", "N_E"): (510,),
    ("N_E", "K"): (320,),
    ("W", "K"): (540, -30, 300),
}

_CONNECTIONS = (
    ("reference.r", "N_F.theta"),
    ("reference.rd", "N_F.thetad"),
    ("reference.rdd", "N_F.thetadd"),
    ("reference.r", "feedback.r"),
    ("reference.payload", "plant.payload"),
    *((f"N_F.{name}", f"F.{name}") for name in ("x", "xd", "xdd", "z")),
    ("K.p", "F.p"),
    ("F.tau_ff", "feedback.tau_ff"),
    ("feedback.tau", "plant.tau"),
    ("plant.theta", "feedback.theta"),
    ("plant.theta", "W.theta"),
    ("plant.tau_meas", "W.tau_meas"),
    ("W.theta_f", "N_E.theta"),
    ("W.theta_fd", "N_E.thetad"),
    ("W.theta_fdd", "N_E.thetadd"),
    *((f"N_E.{name}", f"K.{name}") for name in ("x", "xd", "xdd")),
    ("W.chi_f", "K.chi_f"),
    ("W.tau_f", "K.tau_f"),
)

TORQUE_PATH = ("reference", "N_F", "F", "feedback", "plant")
_PATHS = (TORQUE_PATH, ("W", "N_E", "K"), ("W", "K"))
_NOT_PLOTTED = {"p_std"}


def hexapod(
    interfaces: Mapping[str, Interface],
    *,
    name: str = "hexapod",
    base: float = BASE_STEP,
    sources: Mapping[str, str] | None = None,
) -> System:
    """The loop of [SH, Fig. 3].

    interfaces: by room (`kinematics` serves N_F and N_E) or by instance name, which wins.
    sources: FMU file by instance name, where it is not `<interface name>.fmu`.
    Raises InterfaceError for a room that is missing and for what `System` refuses.
    """
    components = []
    for instance, (room, box) in _LAYOUT.items():
        interface = interfaces.get(instance) or interfaces.get(room)
        if interface is None:
            raise InterfaceError(f"{instance}: no interface given for the room {room!r}")
        source = (sources or {}).get(instance, "")
        components.append(Component(instance, interface, source, box))
    connected = {start for start, _ in _CONNECTIONS}
    plots = tuple(
        f"{c.name}.{v.name}"
        for c in components
        for v in c.interface.outputs
        if f"{c.name}.{v.name}" not in connected and v.name not in _NOT_PLOTTED
    )
    return System(name, tuple(components), _CONNECTIONS, base, plots, _PATHS, _ROUTES)

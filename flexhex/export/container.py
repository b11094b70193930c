"""The controllers of a .ssp as one FMU, and the loop with it."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from pathlib import Path

from flexhex.fmugen import cache as store
from flexhex.fmugen.container import build_container
from flexhex.fmugen.container_parts import NAME, ContainedFmu, Container, Link
from flexhex.fmus.common.errors import InterfaceError
from flexhex.fmus.common.interface import Variable, array_of
from flexhex.ssp.hexapod import PLAYER
from flexhex.ssp.read import Package, read_ssp
from flexhex.ssp.system import Box, Component, System
from flexhex.ssp.write import write_ssp

OUTSIDE = ("reference", "plant")
"""Components that stay FMUs of their own, with a player of wanted poses where there is one."""
SHOWN = ("F.tau_ff", "K.p")
"""Outputs that the container shows although they only connect its parts."""
_BOXES: dict[str, Box] = {
    PLAYER: (-160, 0, -60, 80),
    "reference": (0, 0, 100, 80),
    NAME: (200, 0, 300, 80),
    "plant": (400, 0, 500, 80),
}


_ROUTES: dict[tuple[str, str], tuple[float, ...]] = {
    ("reference", NAME): (150,),
    ("reference", "plant"): (130, -30, 370),
    (PLAYER, "plant"): (-40, -30, 370),
    (NAME, "plant"): (350,),
    ("plant", NAME): (530, 110, 170),
}


def export_container(path: Path, out: Path, platforms: Sequence[str] = ()) -> list[Path]:
    """`out/controller.fmu`, the FMUs outside and `out/hexapod-controller.ssp`, the loop of these.

    platforms: for which computers the one FMU is built, as in `flexhex.fmugen.platforms`.
    Parameter values are those of the FMUs in the .ssp. Raises InterfaceError when the .ssp
    holds FMUs of other makers or lacks the reference or the plant.
    """
    package = read_ssp(path)
    players = [i.name for i in package.instances if i.name == PLAYER]
    outside = (*players, *OUTSIDE)
    container = container_of(package, outside)
    out.mkdir(parents=True, exist_ok=True)
    built = build_container(container, out, store.objects(out / "cache"), platforms)
    system = system_around(package, container)
    beside = []
    for instance in package.instances:
        if instance.name in outside:
            beside.append(out / Path(instance.source).name)
            beside[-1].write_bytes(package.fmus[instance.source])
    return [built, *beside, write_ssp(system, out, out / f"{package.path.stem}-{NAME}.ssp")]


def container_of(
    package: Package, outside: Sequence[str] = OUTSIDE, shown: Sequence[str] = SHOWN
) -> Container:
    """All components but those outside; InterfaceError when one of these is not there.

    It shows what leaves it under the plain name (`tau`), and with the part's name in front
    (`feedback_e`) what nothing takes and what is in `shown`.
    """
    there = [i.name for i in package.instances]
    missing = [name for name in outside if name not in there]
    if missing or len(there) == len(outside):
        what = missing[0] if missing else "a controller"
        raise InterfaceError(f"{package.path}: has no component {what!r}: is it a hexapod.ssp?")
    parts = tuple(
        ContainedFmu(i.name, package.fmus[i.source])
        for i in package.instances
        if i.name not in outside
    )
    links, inputs = _inside(package, parts)
    outputs = {}
    for part in parts:
        for variable in part.interface.outputs:
            names = variable.scalar_names
            takers = {
                w.target for w in package.wires if w.source == part.name and w.output in names
            }
            leaves, own = bool(takers & {*outside}), f"{part.name}_{variable.name}"
            if leaves or not takers or f"{part.name}.{variable.name}" in shown:
                outputs[variable.name if leaves else own] = (part.name, variable.name)
    text = "Controller: feedforward, feedback, filter, kinematics and estimator as one [SH, Fig. 3]"
    return Container(parts, links, inputs, outputs, text, package.base)


def _inside(
    package: Package, parts: tuple[ContainedFmu, ...]
) -> tuple[tuple[Link, ...], tuple[Variable, ...]]:
    """Links into the parts, and the inputs from outside, named and described as their source."""
    names, links = {p.name for p in parts}, []
    inputs: dict[str, Variable] = {}
    for wire in (w for w in package.wires if w.target in names):
        outside = wire.source not in names
        links.append(Link(None if outside else wire.source, wire.output, wire.target, wire.input))
        if outside:
            part = next(p for p in parts if p.name == wire.target)
            array = array_of(wire.input)
            variable = next(v for v in part.interface.inputs if v.name == array)
            name = array_of(wire.output)
            text = package.instance(wire.source).fmu.variables[wire.output].description
            given = dataclasses.replace(variable, name=name, description=text)
            known = inputs.get(name, given)
            inputs[name] = dataclasses.replace(
                known, min=max(known.min, variable.min), max=min(known.max, variable.max)
            )
    return tuple(links), tuple(inputs.values())


def system_around(package: Package, container: Container) -> System:
    """Reference, container, plant."""
    blocks = {
        i.name: ContainedFmu(i.name, package.fmus[i.source]).interface
        for i in package.instances
        if i.name in _BOXES
    }
    sources = {i.name: Path(i.source).name for i in package.instances}
    components = tuple(
        Component(name, blocks.get(name, container.interface), sources.get(name, ""), box)
        for name, box in _BOXES.items()
        if name in (*blocks, NAME)
    )
    inside = {p.name for p in container.parts}
    pairs: dict[tuple[str, str], None] = {}
    for wire in package.wires:
        if wire.target in inside and wire.source not in inside:
            pairs[f"{wire.source}.{wire.output}", f"{NAME}.{wire.output}"] = None
        elif wire.target not in inside:
            source = NAME if wire.source in inside else wire.source
            pairs[f"{source}.{wire.output}", f"{wire.target}.{wire.input}"] = None
    outputs = {tuple(start.split(".", 1)) for start, _ in pairs}
    connected = {f"{name}.{array_of(output)}" for name, output in outputs}
    plots = tuple(
        f"{c.name}.{v.name}"
        for c in components
        for v in c.interface.outputs
        if f"{c.name}.{v.name}" not in connected and not v.name.endswith("p_std")
    )
    return System(package.path.stem, components, tuple(pairs), package.base, plots, routes=_ROUTES)

"""`System` to one portable .ssp: SSP 1.0, flat, what all importers understand alike.

The rules stem from measurements of the importers: prefixes ssd:, ssc:, ssv:, connectors with
type and unit, the FMU type written out, only connectors that are in use, the base step where each
importer looks for it, and parameter sets that repeat the FMUs' own values, since some importers
ignore them. The same system and FMUs give the same bytes.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from flexhex.fmugen.pack import write_zip
from flexhex.fmus.common.archive import read_bytes
from flexhex.fmus.common.errors import InterfaceError
from flexhex.fmus.common.interface import Variable, written
from flexhex.ssp.annotations import annotate_system, experiment
from flexhex.ssp.fmu import Fmu, FmuVariable, read_fmu
from flexhex.ssp.system import Box, Component, System, unit_of
from flexhex.ssp.wiring import Wire, unknown
from flexhex.ssp.xml import child, root, text_of

_SSD_PREFIXES = ("ssd", "ssc", "ssv", "osp", "oms", "flexhex")


def write_ssp(system: System, fmu_dir: str | Path, path: str | Path, *, stop: float = 10.0) -> Path:
    """Write the system with its FMUs, found in fmu_dir; stop [s] is what importers run first.

    Raises InterfaceError when an FMU is missing or is not what its interface says.
    """
    data = {c.source: read_bytes(Path(fmu_dir) / c.source) for c in system.components}
    fmus = {source: read_fmu(content, source) for source, content in data.items()}
    for component in system.components:
        _check_fmu(component, fmus[component.source])
    files = {f"resources/{source}": content for source, content in data.items()}
    for component in system.components:
        files[_ssv_name(component)] = _parameters(fmus[component.source])
    files["SystemStructure.ssd"] = text_of(_description(system, fmus, stop))
    return write_zip(Path(path), files)


def _check_fmu(component: Component, fmu: Fmu) -> None:
    for variable in component.variables:
        for k, name in enumerate(variable.scalar_names):
            actual = fmu.variables.get(name)
            if actual is None:
                text = unknown("variable", name, fmu.variables)
                raise InterfaceError(f"{component.name}: in {fmu.file} {text}; build it anew")
            is_so = (actual.causality, actual.type, actual.unit)
            wanted = (variable.causality, variable.type, unit_of(variable, k))
            if is_so != wanted:
                raise InterfaceError(
                    f"{component.name}.{name}: {fmu.file} has {_said(*is_so)},"
                    f" its interface {_said(*wanted)}: build it anew"
                )


def _said(causality: str, type_: str, unit: str) -> str:
    return f"{causality} [{unit or type_}]"


def ssp_type(variable: FmuVariable) -> str:
    """Of a connector or parameter; an enumeration is an Integer, as libcosim aborts at another."""
    return "Integer" if variable.type == "Enumeration" else variable.type


def _ssv_name(component: Component) -> str:
    return f"resources/{component.name}.ssv"


def _parameters(fmu: Fmu) -> bytes:
    """Parameter set: the FMU's own values; every component calls its set `parameters`."""
    document = root("ssv:ParameterSet", ("ssv", "ssc"), version="1.0", name="parameters")
    values = child(document, "ssv:Parameters")
    parameters = fmu.of("parameter")
    for variable in parameters:
        entry = child(values, "ssv:Parameter", name=variable.name)
        value = variable.start or 0.0
        text = written(variable.type, value)
        unit = {"unit": variable.unit} if variable.type == "Real" else {}
        child(entry, f"ssv:{ssp_type(variable)}", value=text, **unit)
    _units(child(document, "ssv:Units"), {v.unit for v in parameters if v.unit}, [fmu])
    return text_of(document)


def _description(system: System, fmus: Mapping[str, Fmu], stop: float) -> Any:
    document = root(
        "ssd:SystemStructureDescription",
        _SSD_PREFIXES,
        version="1.0",
        name=system.name,
        generationTool="flexhex",
    )
    top = child(document, "ssd:System", name=system.name)
    elements = child(top, "ssd:Elements")
    used = _used_units(system)
    for component in system.components:
        _component(elements, component, used[component.name], fmus[component.source])
    connections = child(top, "ssd:Connections")
    heights = {
        c.name: _heights(c.interface.inputs, used[c.name])
        | _heights(c.interface.outputs, used[c.name])
        for c in system.components
    }
    for wire in system.wires:
        connection = child(
            connections,
            "ssd:Connection",
            startElement=wire.source,
            startConnector=wire.output,
            endElement=wire.target,
            endConnector=wire.input,
        )
        _route(connection, system, wire, heights)
    annotate_system(top, system)
    listed = list(fmus.values())
    names = {unit for units in used.values() for unit in units.values() if unit}
    _units(child(document, "ssd:Units"), names, listed)
    experiment(document, system.base, stop)
    return document


def _used_units(system: System) -> dict[str, dict[str, str]]:
    """Connectors in use: component -> scalar name -> unit."""
    in_use = {(w.source, w.output) for w in system.wires}
    in_use |= {(w.target, w.input) for w in system.wires}
    for plot in system.plots:
        name, _, variable = plot.partition(".")
        in_use |= {(name, scalar) for scalar in system.component(name).find(variable)}
    return {
        c.name: {
            name: unit_of(v, k)
            for v in (*c.interface.inputs, *c.interface.outputs)
            for k, name in enumerate(v.scalar_names)
            if (c.name, name) in in_use
        }
        for c in system.components
    }


def _component(elements: Any, component: Component, used: Mapping[str, str], fmu: Fmu) -> None:
    element = child(
        elements,
        "ssd:Component",
        name=component.name,
        type="application/x-fmu-sharedlibrary",
        source=f"resources/{component.source}",
        description=component.interface.description,
    )
    if used:
        connectors = child(element, "ssd:Connectors")
        _connectors(connectors, "input", 0.0, component.interface.inputs, used, fmu)
        _connectors(connectors, "output", 1.0, component.interface.outputs, used, fmu)
    if component.box:
        corners = zip(("x1", "y1", "x2", "y2"), component.box, strict=True)
        child(element, "ssd:ElementGeometry", **{key: repr(float(v)) for key, v in corners})
    bindings = child(element, "ssd:ParameterBindings")
    child(
        bindings,
        "ssd:ParameterBinding",
        type="application/x-ssp-parameter-set",
        source=_ssv_name(component),
    )


def _connectors(
    parent: Any,
    kind: str,
    x: float,
    variables: tuple[Variable, ...],
    used: Mapping[str, str],
    fmu: Fmu,
) -> None:
    for name, y in _heights(variables, used).items():
        connector = child(parent, "ssd:Connector", name=name, kind=kind)
        variable = fmu.variables[name]
        unit = {"unit": variable.unit} if variable.type == "Real" else {}
        child(connector, f"ssc:{ssp_type(variable)}", **unit)
        child(connector, "ssd:ConnectorGeometry", x=repr(x), y=repr(y))


def _heights(variables: tuple[Variable, ...], used: Mapping[str, str]) -> dict[str, float]:
    """Connectors from top to bottom (1 to 0); the elements of an array share one place."""
    shown = [v for v in variables if any(name in used for name in v.scalar_names)]
    return {
        name: round(1 - row / (len(shown) + 1), 4)
        for row, variable in enumerate(shown, start=1)
        for name in variable.scalar_names
        if name in used
    }


def _route(
    connection: Any, system: System, wire: Wire, heights: Mapping[str, Mapping[str, float]]
) -> None:
    """Corners between the two connectors, which every reader knows by itself."""
    source, target = system.component(wire.source), system.component(wire.target)
    route = system.routes.get((wire.source, wire.target))
    if not (route and source.box and target.box):
        return
    first, last = heights[wire.source][wire.output], heights[wire.target][wire.input]
    y = [_height(source.box, first), *map(float, route[1::2]), _height(target.box, last)]
    corners = [(float(x), level) for k, x in enumerate(route[::2]) for level in y[k : k + 2]]
    child(
        connection,
        "ssd:ConnectionGeometry",
        pointsX=" ".join(repr(x) for x, _ in corners),
        pointsY=" ".join(repr(level) for _, level in corners),
    )


def _height(box: Box, share: float) -> float:
    return round(min(box[1], box[3]) + share * abs(box[3] - box[1]), 4)


def _units(parent: Any, names: set[str], fmus: list[Fmu]) -> None:
    known = {name: base for fmu in fmus for name, base in fmu.units.items()}
    for name in sorted(names):
        if name not in known:
            raise InterfaceError(f"unit {name!r} is declared by none of the FMUs: build them anew")
        child(child(parent, "ssc:Unit", name=name), "ssc:BaseUnit", **dict(known[name]))

"""Reads a .ssp back: components with their FMUs, wires, parameters, base step.

Reads what `flexhex.ssp.write` writes and any flat SSP 1.x of FMI 2.0 co-simulation FMUs with
component- or system-level parameter sets. What it cannot run it refuses by name.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any
from zipfile import ZipFile

from flexhex.fmus.common.archive import (
    open_zip,
    read_bytes,
    read_member,
    size_objection,
    unpacked_size,
)
from flexhex.fmus.common.errors import InterfaceError
from flexhex.ssp.fmu import Fmu, read_fmu
from flexhex.ssp.parameters import Setting, Units, settings, units_of
from flexhex.ssp.wiring import Port, Wire, check_wires, renamed, unknown, whole_steps
from flexhex.ssp.xml import NAMESPACES, parse

BASE_STEPS = (
    ("flexhex:Schedule", "baseStep"),
    ("osp:FixedStepAlgorithm", "baseStepSize"),
    ("oms:FixedStepMaster", "stepSize"),
    ("oms:SimulationInformation", "fixedStepSize"),
)
"""Elements and attributes that may hold the base step [s]; the first present is taken."""
_FMU_TYPES = (None, "", "application/x-fmu-sharedlibrary")


@dataclass(frozen=True)
class Instance:
    """One component of a .ssp: parameters are what its parameter sets say, by name.

    ignored: names in the parameter sets that the FMU does not have (as SSP prescribes).
    """

    name: str
    source: str
    fmu: Fmu
    parameters: dict[str, float]
    ignored: tuple[str, ...] = ()


@dataclass(frozen=True)
class Package:
    """A .ssp in memory; base [s] is its base step, fmus the FMU files by source."""

    path: Path
    name: str
    base: float
    instances: tuple[Instance, ...]
    wires: tuple[Wire, ...]
    fmus: dict[str, bytes] = field(repr=False)

    def instance(self, name: str) -> Instance:
        """The component of that name, or InterfaceError."""
        for instance in self.instances:
            if instance.name == name:
                return instance
        raise InterfaceError(unknown("component", name, (i.name for i in self.instances)))


def read_ssp(path: str | Path) -> Package:
    """Read and check a .ssp.

    Raises InterfaceError for a missing or broken file, invalid XML, a missing FMU, what
    the executor does not run (nested systems, transformations), and wiring mistakes.
    """
    return _Reader(Path(path)).package()


def period(instance: Instance, base: float, overrides: dict[str, float] | None = None) -> int:
    """Base steps between two steps of a component: its parameter Ts, else 1."""
    Ts = instance.fmu.variables.get("Ts")
    if Ts is None or Ts.causality != "parameter" or Ts.start is None:
        return 1
    value = {**instance.parameters, **(overrides or {})}.get("Ts", Ts.start)
    return whole_steps(instance.name, value, base)


class _Reader:
    """One .ssp while it is read; every complaint begins with its file name."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.archive: ZipFile = open_zip(read_bytes(path), str(path))
        self.fmus: dict[str, bytes] = {}
        self.size = 0
        """What they unpack to [bytes]."""
        self.read: dict[str, Fmu] = {}
        self.units: Units = {}

    def package(self) -> Package:
        if "modelDescription.xml" in self.archive.namelist():
            raise self.error("an FMU, not a system description (.ssp)")
        document = parse(self.member("SystemStructure.ssd"), f"{self.path}: SystemStructure.ssd")
        if document.tag != f"{{{NAMESPACES['ssd']}}}SystemStructureDescription":
            raise self.error("SystemStructure.ssd is no SSP 1.x system description")
        top = document.find("ssd:System", NAMESPACES)
        if top is None:
            raise self.error("SystemStructure.ssd holds no System")
        self.refuse(top)
        self.units = units_of(document.find("ssd:Units", NAMESPACES))
        overrides = list(self.parameter_sets(top))
        elements = top.iterfind("ssd:Elements/ssd:Component", NAMESPACES)
        instances = tuple(self.instance(element, overrides) for element in elements)
        if not instances:
            raise self.error("no components: nothing to run")
        connections = top.iterfind("ssd:Connections/ssd:Connection", NAMESPACES)
        wires = tuple(self.wire(element) for element in connections)
        self.check(instances, wires)
        base = self.base_step(document, instances)
        name = document.get("name", self.path.stem)
        return Package(self.path, name, base, instances, wires, self.fmus)

    def error(self, text: str) -> InterfaceError:
        return InterfaceError(f"{self.path}: {text}")

    def member(self, name: str) -> bytes:
        return read_member(self.archive, name, str(self.path))

    def refuse(self, top: Any) -> None:
        for tag, text in (
            ("ssd:Elements/ssd:System", "nested systems"),
            ("ssd:Elements/ssd:SignalDictionaryReference", "signal dictionaries"),
            ("ssd:Connections/ssd:Connection/ssc:LinearTransformation", "transformations"),
        ):
            if top.find(tag, NAMESPACES) is not None:
                raise self.error(f"holds {text}: the executor runs flat systems; use FMPy")

    def instance(self, element: Any, overrides: list[Setting]) -> Instance:
        name, source = element.get("name", ""), element.get("source", "")
        if element.get("type") not in _FMU_TYPES:
            raise self.error(f"{name}: component type {element.get('type')!r} is no FMU")
        if source not in self.read:
            self.fmus[source] = self.member(source)
            self.read[source] = read_fmu(self.fmus[source], f"{self.path}: {source}")
            self.size += unpacked_size(open_zip(self.fmus[source], source).infolist())
            if objection := size_objection(self.size):
                raise self.error(f"{name}: with its FMU the system {objection}")
        fmu = self.read[source]
        prefix = f"{name}."
        own = [replace(s, name=prefix + s.name) for s in self.parameter_sets(element)]
        # a set at system level wins over one of the component
        mine = [s for s in (*own, *overrides) if s.name.startswith(prefix)]
        chosen = {s.name.removeprefix(prefix): s for s in mine}
        known = {k: self.value(s, fmu, k) for k, s in chosen.items() if k in fmu.variables}
        for old in set(chosen) - set(known):
            # SSP has unknown names ignored: an old one would be lost without a word
            if renamed(old, fmu.variables):
                raise self.error(f"{name}: {unknown('parameter', old, fmu.variables)}")
        return Instance(name, source, fmu, known, tuple(sorted(set(chosen) - set(known))))

    def value(self, setting: Setting, fmu: Fmu, variable: str) -> float:
        """In the unit of the FMU's variable."""
        try:
            return setting.value_for(fmu.variables[variable], fmu)
        except InterfaceError as error:
            raise self.error(str(error)) from None

    def parameter_sets(self, element: Any) -> Iterator[Setting]:
        """Every parameter in the element's parameter sets, later ones last."""
        for binding in element.iterfind("ssd:ParameterBindings/ssd:ParameterBinding", NAMESPACES):
            if binding.find("ssd:ParameterMapping", NAMESPACES) is not None:
                raise self.error("holds a parameter mapping: name the parameters directly")
            inline = binding.find("ssd:ParameterValues/ssv:ParameterSet", NAMESPACES)
            source, prefix = binding.get("source"), binding.get("prefix", "")
            where = f"{self.path}: {source}" if source else str(self.path)
            if source:
                inline = parse(self.member(source), where)
            if inline is None:
                raise self.error("a ParameterBinding has neither a source nor ParameterValues")
            try:
                yield from settings(inline, self.units, prefix)
            except InterfaceError as error:
                raise InterfaceError(f"{where}: {error}") from None

    def wire(self, element: Any) -> Wire:
        keys = ("startElement", "startConnector", "endElement", "endConnector")
        ends = [element.get(key) for key in keys]
        if None in ends:
            raise self.error("connects to a connector of the system: the executor has none")
        return Wire(*ends)

    def check(self, instances: tuple[Instance, ...], wires: tuple[Wire, ...]) -> None:
        names = [i.name for i in instances]
        for name in names:
            if names.count(name) > 1:
                raise self.error(f"component {name!r} exists twice: rename one")
        ports = {
            i.name: {v.name: Port(v.causality, v.unit, v.type) for v in i.fmu.variables.values()}
            for i in instances
        }
        try:
            check_wires(wires, ports, all_fed=False)
        except InterfaceError as error:
            raise self.error(str(error)) from None
        types = {i.name: i.fmu.variables for i in instances}
        for wire in wires:
            for name, variable in ((wire.source, wire.output), (wire.target, wire.input)):
                if types[name][variable].type == "String":
                    raise self.error(f"connection {wire}: {name}.{variable} is a String")

    def base_step(self, document: Any, instances: tuple[Instance, ...]) -> float:
        """[s]: our schedule, else a known annotation, else the FMUs' smallest step size."""
        for tag, key in BASE_STEPS:
            element = document.find(f".//{tag}[@{key}]", NAMESPACES)
            if element is not None:
                return self.positive(element.get(key), tag)
        sizes = [i.fmu.step_size for i in instances if i.fmu.step_size]
        if not sizes:
            raise self.error("names no base step: write osp:FixedStepAlgorithm baseStepSize")
        return min(sizes)

    def positive(self, text: str, where: str) -> float:
        try:
            step = float(text)
        except ValueError:
            step = math.nan
        if not (0 < step < math.inf):
            raise self.error(f"{where} is {text!r}, must be a positive number of seconds")
        return step

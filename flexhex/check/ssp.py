"""`flexhex check` of a system description: schema, wiring, units, sample times, its FMUs."""

from __future__ import annotations

import math
import tempfile
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from flexhex.check.fmu import check_fmu
from flexhex.check.subject import parsed
from flexhex.fmus.common.archive import check_members, open_zip, read_member
from flexhex.fmus.common.errors import InterfaceError
from flexhex.ssp.read import BASE_STEPS, Instance, Package, period, read_ssp
from flexhex.ssp.xml import NAMESPACES, parse

OMSIMULATOR = (
    "ssd:System/ssd:Annotations/ssc:Annotation[1][@type='org.openmodelica']"
    "/oms:Annotations/oms:SimulationInformation/oms:FixedStepMaster"
)
"""Where OMSimulator looks for its step: the first annotation of the system, no other."""


def check_ssp(path: Path) -> list[str]:
    """Complaints about a .ssp and every FMU in it. InterfaceError for one that cannot be read."""
    package = read_ssp(path)
    errors = check_system(package)
    with tempfile.TemporaryDirectory() as folder:
        for source, data in sorted(package.fmus.items()):
            fmu = Path(folder) / Path(source).name
            fmu.write_bytes(data)
            errors += [t.replace(str(fmu), f"{path}: {source}") for t in check_fmu(fmu)]
    return errors


def check_system(package: Package) -> list[str]:
    """Complaints about the system description alone."""
    path = package.path
    with open_zip(path, str(path)) as archive:
        check_members(archive, str(path))
        text = read_member(archive, "SystemStructure.ssd", str(path))
    document = parse(text, f"{path}: SystemStructure.ssd")
    return [f"{path}: {text}" for text in _system(package, document)]


def _system(package: Package, document: Any) -> Iterator[str]:
    yield from _schema(document)
    yield from _steps(package, document)
    yield from _schedule(package, document)
    yield from _experiment(document)
    yield from _fed(package)
    yield from _declared(package, document)
    elements = document.iterfind("ssd:System/ssd:Elements/ssd:Component", NAMESPACES)
    for element in elements:
        instance = package.instance(element.get("name", ""))
        yield from _connectors(instance, element)
        yield from _parameters(instance)


def _schema(document: Any) -> Iterator[str]:
    """SSP 1.0's schema, which FMPy brings along."""
    from fmpy.ssp.ssd import validate_tree

    try:
        validate_tree(document, "SystemStructureDescription.xsd")
    except Exception as error:  # fmpy raises plain Exception
        yield " ".join(str(error).split())


def _steps(package: Package, document: Any) -> Iterator[str]:
    """One base step for all importers; sample times are whole numbers of it."""
    said = [
        (f"{tag} {key}", step)
        for tag, key in BASE_STEPS
        for element in document.iterfind(f".//{tag}[@{key}]", NAMESPACES)
        for step in [parsed(element.get(key))]
    ]
    for where, step in said[1:]:
        # written so that what is no number is blamed too
        if not abs(step / package.base - 1) <= 1e-9:
            yield f"{where} is {step:.9g} s, {said[0][0]} {package.base:.9g} s: make them equal"
    if document.find(".//oms:SimulationInformation", NAMESPACES) is not None:
        master = document.find(OMSIMULATOR, NAMESPACES)
        if master is None or not master.get("stepSize"):
            yield (
                "oms:SimulationInformation without oms:FixedStepMaster stepSize in the first"
                " annotation of the system: OMSimulator would step by 0.001 s"
            )
    for instance in package.instances:
        try:
            period(instance, package.base)
        except InterfaceError as error:
            yield str(error)
        ours = "Ts" in instance.fmu.variables
        step_size = instance.fmu.step_size
        if ours and step_size and abs(step_size / package.base - 1) > 1e-9:
            yield (
                f"{instance.name}: made for base steps of {step_size:.9g} s,"
                f" the system steps by {package.base:.9g} s"
            )


def _schedule(package: Package, document: Any) -> Iterator[str]:
    """The periods that the schedule states are those of the sample times."""
    schedule = document.find(".//flexhex:Schedule", NAMESPACES)
    if schedule is None:
        return
    stated = {
        e.get("component", ""): e.get("steps", "")
        for e in schedule.iterfind("flexhex:Period", NAMESPACES)
    }
    for instance in package.instances:
        try:
            steps = str(period(instance, package.base))
        except InterfaceError:  # blamed by _steps
            continue
        said = stated.pop(instance.name, None)
        if said is None:
            yield f"flexhex:Schedule lacks {instance.name}"
        elif said != steps:
            yield f"flexhex:Schedule: {instance.name} every {said} base steps, its Ts says {steps}"
    for name in stated:
        yield f"flexhex:Schedule names {name!r}, no component of the system"


def _experiment(document: Any) -> Iterator[str]:
    experiment = document.find("ssd:DefaultExperiment", NAMESPACES)
    if experiment is None:
        return
    start, stop = (parsed(experiment.get(key), 0.0) for key in ("startTime", "stopTime"))
    # written so that what is no number is blamed too
    if experiment.get("stopTime") and not start < stop < math.inf:
        yield f"DefaultExperiment: from {start:.9g} s to {stop:.9g} s, must end after it starts"


def _declared(package: Package, document: Any) -> Iterator[str]:
    """Connections end at connectors that their components declare."""
    declared = {
        (element.get("name"), connector.get("name"))
        for element in document.iterfind("ssd:System/ssd:Elements/ssd:Component", NAMESPACES)
        for connector in element.iterfind("ssd:Connectors/ssd:Connector", NAMESPACES)
    }
    for wire in package.wires:
        for component, name in ((wire.source, wire.output), (wire.target, wire.input)):
            if (component, name) not in declared:
                yield f"connection {wire}: {component} declares no connector {name}"


def _fed(package: Package) -> Iterator[str]:
    fed = {(wire.target, wire.input) for wire in package.wires}
    for instance in package.instances:
        missing = [v.name for v in instance.fmu.of("input") if (instance.name, v.name) not in fed]
        if missing:
            more = f" and {len(missing) - 1} more" if len(missing) > 1 else ""
            yield f"{instance.name}.{missing[0]}{more}: fed by nothing"


def _connectors(instance: Instance, element: Any) -> Iterator[str]:
    """Connectors agree with the FMU's variables: name, kind, unit."""
    names = []
    for connector in element.iterfind("ssd:Connectors/ssd:Connector", NAMESPACES):
        name, kind = connector.get("name", ""), connector.get("kind")
        names.append(name)
        variable = instance.fmu.variables.get(name)
        where = f"{instance.name}.{name}"
        if variable is None:
            yield f"{where}: the FMU has no such variable"
            continue
        if kind not in (variable.causality, "inout"):
            yield f"{where}: {kind} in the system, {variable.causality} in the FMU"
        typed = connector.find("ssc:Real", NAMESPACES)
        # libcosim does not know enumerations: an Integer is as good
        types = [variable.type, *(["Integer"] if variable.type == "Enumeration" else [])]
        if not any(connector.find(f"ssc:{t}", NAMESPACES) is not None for t in types):
            yield f"{where}: another type than in the FMU ({variable.type})"
        unit = None if typed is None else typed.get("unit")
        if unit is not None and variable.unit and unit != variable.unit:
            yield f"{where}: unit {unit} in the system, {variable.unit} in the FMU"
    for name, count in Counter(names).items():
        if count > 1:
            yield f"{instance.name}.{name}: {count} connectors of that name"


def _parameters(instance: Instance) -> Iterator[str]:
    for name in instance.ignored:
        yield f"{instance.name}.{name}: is set, but the FMU has no such variable"
    for name, value in instance.parameters.items():
        variable = instance.fmu.variables[name]
        if not variable.min <= value <= variable.max or not math.isfinite(value):
            unit = f" {variable.unit}".removesuffix(" 1")
            yield (
                f"{instance.name}.{name} = {value:.9g}{unit},"
                f" allowed {variable.min:.9g} to {variable.max:.9g}"
            )
        if variable.causality not in ("parameter", "input"):
            yield f"{instance.name}.{name}: is set, but is of causality {variable.causality}"

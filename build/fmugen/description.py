"""modelDescription.xml of an FMU (FMI 2.0 co-simulation)."""

from __future__ import annotations

import math
from collections.abc import Sequence

from lxml import etree

from flexhex.fmugen import VERSION
from flexhex.fmugen.sources import variables
from flexhex.fmugen.units import display_unit, unit
from flexhex.fmus.common.interface import Interface, Variable, written

STOP = 10.0
"""End of the default experiment [s]: the reference rests for two seconds and moves then."""
LOG_CATEGORIES = {
    "logStatusError": "refused calls and values",
    "logStatusWarning": "faults that the FMU reports while it goes on",
    "logEvents": "instantiation, initialisation, reset",
}


def model_description(
    interface: Interface, base_step: float, guid: str, sources: Sequence[str]
) -> bytes:
    """The XML text, ready for the archive; sources: files of `sources/` to compile."""
    root = etree.Element(
        "fmiModelDescription",
        fmiVersion="2.0",
        modelName=interface.name,
        guid=guid,
        description=interface.description,
        author="the flexhex authors",
        version=VERSION,
        copyright="Copyright (c) 2026 the flexhex authors",
        license="MIT",
        generationTool=f"flexhex {VERSION}",
        variableNamingConvention="structured",
        numberOfEventIndicators="0",
    )
    cosim = etree.SubElement(
        root,
        "CoSimulation",
        modelIdentifier=interface.name,
        needsExecutionTool="false",
        canHandleVariableCommunicationStepSize="true",
        canInterpolateInputs="false",
        maxOutputDerivativeOrder="0",
        canRunAsynchronuously="false",
        canBeInstantiatedOnlyOncePerProcess="false",
        canNotUseMemoryManagementFunctions="false",
        canGetAndSetFMUstate="true",
        canSerializeFMUstate="true",
        providesDirectionalDerivative="false",
    )
    files = etree.SubElement(cosim, "SourceFiles")
    for name in sources:
        etree.SubElement(files, "File", name=name)
    listed = variables(interface)
    _units(root, listed)
    _types(root, interface.name, listed)
    categories = etree.SubElement(root, "LogCategories")
    for name, text in LOG_CATEGORIES.items():
        etree.SubElement(categories, "Category", name=name, description=text)
    times = {"startTime": "0", "stopTime": repr(STOP), "stepSize": repr(base_step)}
    etree.SubElement(root, "DefaultExperiment", times)
    _variables(etree.SubElement(root, "ModelVariables"), interface.name, listed)
    _structure(root, listed)
    return bytes(etree.tostring(root, xml_declaration=True, encoding="UTF-8", pretty_print=True))


def _units(root: etree._Element, listed: Sequence[Variable]) -> None:
    listed = [v for v in listed if v.type == "Real"]
    used = sorted({name for v in listed for name in (v.units or (v.unit,))})
    definitions = etree.SubElement(root, "UnitDefinitions")
    for name in used:
        where = next(v.name for v in listed if name in (v.units or (v.unit,)))
        definition = unit(name, where)
        element = etree.SubElement(definitions, "Unit", name=name)
        exponents = {base: str(power) for base, power in definition.exponents.items()}
        etree.SubElement(element, "BaseUnit", exponents)
        for display, factor in definition.display:
            etree.SubElement(element, "DisplayUnit", name=display, factor=repr(factor))


def type_name(model: str, variable: Variable) -> str:
    """Of the enumeration of a variable, `plant_fault`."""
    return f"{model}_{variable.name}"


def _types(root: etree._Element, model: str, listed: Sequence[Variable]) -> None:
    definitions = etree.SubElement(root, "TypeDefinitions")
    for variable in (v for v in listed if v.type == "Enumeration"):
        simple = etree.SubElement(definitions, "SimpleType", name=type_name(model, variable))
        items = etree.SubElement(simple, "Enumeration")
        for value, item in enumerate(variable.items):
            text = {"name": item.name, "value": str(value), "description": item.description}
            etree.SubElement(items, "Item", text)


def _variables(parent: etree._Element, model: str, listed: Sequence[Variable]) -> None:
    reference = 0
    for variable in listed:
        for k, name in enumerate(variable.scalar_names):
            scalar = etree.SubElement(
                parent,
                "ScalarVariable",
                name=name,
                valueReference=str(reference),
                description=variable.description,
                causality=variable.causality,
                variability=variable.variability,
            )
            typed = etree.SubElement(scalar, variable.type)
            if variable.type == "Real":
                _of_real(typed, variable, k)
            elif variable.type == "Enumeration":
                typed.set("declaredType", type_name(model, variable))
            if variable.type in ("Real", "Integer"):
                for bound, value in (("min", variable.lows[k]), ("max", variable.max)):
                    if math.isfinite(value):
                        typed.set(bound, written(variable.type, value))
            if variable.causality == "output":
                scalar.set("initial", "calculated")
            else:
                typed.set("start", written(variable.type, variable.starts[k]))
            reference += 1


def _of_real(typed: etree._Element, variable: Variable, k: int) -> None:
    name = variable.units[k] if variable.units else variable.unit
    typed.set("unit", name)
    shown = display_unit(variable, name)
    if shown:
        typed.set("displayUnit", shown)
    nominal = variable.nominal
    if nominal is None and variable.causality != "parameter":
        nominal = unit(name, variable.name).nominal
    if nominal is not None:
        typed.set("nominal", repr(float(nominal)))


def _structure(root: etree._Element, listed: Sequence[Variable]) -> None:
    """Outputs depend on no input of the same instant: results appear one Ts later."""
    structure = etree.SubElement(root, "ModelStructure")
    outputs = etree.SubElement(structure, "Outputs")
    initial = etree.SubElement(structure, "InitialUnknowns")
    first, position = {}, 1
    for variable in listed:
        first[variable.name] = position
        position += variable.count
    for variable in listed:
        if variable.causality != "output":
            continue
        sources = [next(v for v in listed if v.name == name) for name in variable.initial_from]
        for k in range(variable.count):
            index = str(first[variable.name] + k)
            etree.SubElement(outputs, "Unknown", index=index, dependencies="")
            knowns = [first[s.name] + (k if s.count == variable.count else 0) for s in sources]
            text = " ".join(str(known) for known in sorted(knowns))
            etree.SubElement(initial, "Unknown", index=index, dependencies=text)

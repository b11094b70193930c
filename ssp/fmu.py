"""What an .fmu file says about itself: variables, units, GUID, where its binary is."""

from __future__ import annotations

import hashlib
import math
import platform
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

from flexhex.fmus.common.archive import open_zip, read_member
from flexhex.fmus.common.errors import InterfaceError
from flexhex.fmus.common.interface import array_of, indices, value_of
from flexhex.ssp.xml import parse

TYPES = ("Real", "Integer", "Boolean", "String", "Enumeration")
_INDEX = re.compile(r"\[\d+\]$")
DESCRIPTIONS = 64
"""Descriptions kept in memory: the variants of a run share most of theirs, about 0.3 MB each."""


_WHOLE = {
    "Integer": "a whole number",
    "Enumeration": "the whole number of an item",
    "Boolean": "0 or 1",
    "String": "a text, which the executor does not set",
}


@dataclass(frozen=True)
class FmuVariable:
    """One scalar variable; type is Real, Integer, ...; array: the array that it is an element of,
    else its own name. A Boolean is 0 or 1, a String has no start, min, max.

    declared_type: of an enumeration, where `Fmu.enumerations` lists its items; its description
    ends with them, so that results say what their numbers mean.
    """

    name: str
    array: str
    reference: int
    type: str
    causality: str
    variability: str
    unit: str
    description: str
    start: float | None
    min: float
    max: float
    declared_type: str = ""

    def objection(self, value: float) -> str:
        """Why the type does not take a value, in words; empty where it does."""
        whole = value == round(value) and abs(value) < 2**31
        return "" if self.type == "Real" or whole else f"{value:.9g}, must be {_WHOLE[self.type]}"


@dataclass(frozen=True)
class Fmu:
    """modelDescription.xml of one FMI 2.0 co-simulation FMU.

    units: exponents by unit name as attributes of BaseUnit. enumerations: names of the items and
    their values, by type. sha256: of the whole file.
    """

    file: str
    model: str
    guid: str
    step_size: float | None
    variables: Mapping[str, FmuVariable]
    units: Mapping[str, Mapping[str, str]]
    enumerations: Mapping[str, Mapping[str, int]]
    log_categories: tuple[str, ...]
    sha256: str

    def of(self, *causalities: str) -> list[FmuVariable]:
        """Variables of these causalities in the order of the file."""
        return [v for v in self.variables.values() if v.causality in causalities]


def binary_path(model: str) -> str:
    """Path of the shared library inside the archive on this machine.

    Raises InterfaceError on a platform for which FMI 2.0 has no name.
    """
    folders = {"Linux": ("linux64", "so"), "Darwin": ("darwin64", "dylib")}
    system = platform.system()
    if system not in folders:
        raise InterfaceError(f"the executor does not run on {system}: use Linux or FMPy")
    folder, suffix = folders[system]
    if system == "Linux" and platform.machine() == "aarch64":
        folder = "aarch64-linux"
    return f"binaries/{folder}/{model}.{suffix}"


def read_fmu(data: bytes, file: str) -> Fmu:
    """Read an FMU from its bytes; file is the name for messages.

    Raises InterfaceError when it is no zip, holds no or an invalid modelDescription.xml,
    or is no FMI 2.0 co-simulation FMU.
    """
    text = read_member(open_zip(data, file), "modelDescription.xml", file)
    try:
        described = _described(text)
    except InterfaceError as error:
        raise InterfaceError(f"{file}: {error}") from None
    return replace(described, file=file, sha256=hashlib.sha256(data).hexdigest())


@lru_cache(maxsize=DESCRIPTIONS)
def _described(text: bytes) -> Fmu:
    """What a modelDescription.xml says, without file and hash; InterfaceError without the file."""
    root = parse(text, "modelDescription.xml")
    version, cosimulation = root.get("fmiVersion"), root.find("CoSimulation")
    if version != "2.0" or cosimulation is None:
        kind = "co-simulation" if cosimulation is not None else "no co-simulation"
        raise InterfaceError(f"FMI {version or '?'}, {kind}: export it for FMI 2.0 co-simulation")
    experiment = root.find("DefaultExperiment")
    size = None if experiment is None else experiment.get("stepSize")
    try:
        step = None if size is None else float(size)
        elements, enumerations = list(root.iterfind("ModelVariables/*")), _enumerations(root)
        ours = str(root.get("generationTool")).partition(" ")[0] == "flexhex"
        arrays = _arrays([e.get("name", "") for e in elements], ours)
        variables = [_variable(element, arrays, enumerations) for element in elements]
    except ValueError as error:
        raise InterfaceError(f"modelDescription.xml: {error}") from None
    return Fmu(
        file="",
        model=str(cosimulation.get("modelIdentifier")),
        guid=str(root.get("guid")),
        step_size=step,
        variables={v.name: v for v in variables},
        units=_units(root),
        enumerations=enumerations,
        log_categories=tuple(c.get("name", "") for c in root.iterfind("LogCategories/Category")),
        sha256="",
    )


def _arrays(names: Sequence[str], ours: bool) -> dict[str, str]:
    """Array by name of its elements. Of flexhex: what stands before the first dot or bracket; of
    other makers: `a` of `a[1]` ... `a[n]` when these are all there."""
    if ours:
        return {name: array_of(name) for name in names}
    arrays: dict[str, set[str]] = {}
    for name in names:
        arrays.setdefault(_INDEX.sub("", name), set()).add(name)
    whole = {
        a for a, members in arrays.items() if members == {a + k for k in indices(len(members))}
    }
    return {name: array if array in whole else name for array, m in arrays.items() for name in m}


def _variable(
    element: Any, arrays: Mapping[str, str], enumerations: Mapping[str, Mapping[str, int]]
) -> FmuVariable:
    kind = next((t for t in TYPES if element.find(t) is not None), "")
    typed = element.find(kind) if kind else None
    name, reference = element.get("name"), element.get("valueReference")
    if typed is None or name is None or reference is None:
        raise InterfaceError("a variable lacks name, type or reference: build it anew")
    numbers = {} if kind == "String" else typed
    start = numbers.get("start")
    items = enumerations.get(numbers.get("declaredType", ""), {})
    values = (0, 1) if kind == "Boolean" else items.values() or (-math.inf, math.inf)
    text = element.get("description", "")
    return FmuVariable(
        name=name,
        array=arrays[name],
        reference=int(reference),
        type=kind,
        causality=element.get("causality", "local"),
        variability=element.get("variability", "continuous"),
        unit=typed.get("unit", ""),
        description=f"{text}: {listed(items)}" if items else text,
        start=None if start is None else value_of(start),
        min=float(numbers.get("min", min(values))),
        max=float(numbers.get("max", max(values))),
        declared_type=typed.get("declaredType", ""),
    )


def listed(items: Mapping[str, int]) -> str:
    """Items of an enumeration by value: `0 none, 1 refused, 2 end_stop`."""
    return ", ".join(f"{value} {name}" for name, value in items.items())


def item_of(description: str, value: float) -> str:
    """Name of a value in what `listed` wrote behind a description; empty where it is not there."""
    match = re.search(rf"(?:: |, ){value:.0f} (\w+)(?=, \d|$)", description)
    return match[1] if match else ""


def _enumerations(root: Any) -> dict[str, dict[str, int]]:
    return {
        str(simple.get("name")): {
            str(item.get("name")): int(item.get("value", ""))
            for item in simple.iterfind("Enumeration/Item")
        }
        for simple in root.iterfind("TypeDefinitions/SimpleType")
        if simple.find("Enumeration") is not None
    }


def _units(root: Any) -> dict[str, dict[str, str]]:
    units = {}
    for unit in root.iterfind("UnitDefinitions/Unit"):
        base = unit.find("BaseUnit")
        units[unit.get("name")] = {} if base is None else dict(base.attrib)
    return units

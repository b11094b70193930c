"""The variables that a modelDescription.xml declares: values, ranges, units, combinations."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterator

from flexhex.check.subject import Scalar, Subject, parsed
from flexhex.fmugen.units import UNITS, unit
from flexhex.fmus.common.errors import InterfaceError
from flexhex.fmus.common.interface import STRUCTURED

VARIABILITIES = {
    "parameter": {"fixed", "tunable"},
    "calculatedParameter": {"fixed", "tunable"},
    "input": {"discrete", "continuous"},
    "output": {"constant", "discrete", "continuous"},
    "local": {"constant", "fixed", "tunable", "discrete", "continuous"},
    "independent": {"continuous"},
}
"""Causality -> what the standard allows beside it (section 2.2.7)."""
NUMERIC = ("Real", "Integer", "Enumeration")


def variables(subject: Subject) -> Iterator[str]:
    """Complaints about all variables and units."""
    for name, count in Counter(v.name for v in subject.variables).items():
        if count > 1:
            yield f"variable {name} is declared {count} times"
    yield from _names(subject)
    for variable in subject.variables:
        yield from _combination(variable)
        if variable.kind in NUMERIC:
            yield from _range(variable)
    yield from _aliases(subject)
    yield from _units(subject)
    yield from _types(subject)
    if subject.ours:
        yield from _sample_time(subject)


def _names(subject: Subject) -> Iterator[str]:
    """Names of the convention that the description declares."""
    structured = subject.root.get("variableNamingConvention") == "structured"
    for variable in subject.variables:
        if structured and not STRUCTURED.fullmatch(variable.name):
            yield f"{variable.name!r} is no structured name like arm[3].lam or der(x)"
        elif not structured and re.search(r"[\r\n\t]", variable.name):
            yield f"{variable.name!r}: a line break or tab in a name"


def _combination(v: Scalar) -> Iterator[str]:
    allowed = VARIABILITIES.get(v.causality)
    # without a word the standard takes continuous, also for what is not Real: let it pass
    if allowed is not None and v.variability not in allowed:
        yield (
            f"{v.name}: causality {v.causality} with variability {v.variability},"
            f" allowed: {', '.join(sorted(allowed))}"
        )
    if not v.reference:
        yield f"{v.name} has no valueReference"
    elif not v.reference.isdigit() or int(v.reference) >= 2**32:
        yield f"{v.name}: value reference {v.reference!r} is no unsigned 32-bit number"
    has_start = "start" in v.attributes
    wants = v.causality in ("input", "parameter") or v.variability == "constant"
    if (wants or v.initial in ("exact", "approx")) and not has_start and v.causality != "local":
        yield f"{v.name}: has no start value, which causality {v.causality} needs"
    if has_start and v.causality == "output" and v.initial == "calculated":
        yield f"{v.name}: has a start value, although it is calculated"


def _range(v: Scalar) -> Iterator[str]:
    low, high = v.number("min", -math.inf), v.number("max", math.inf)
    for key in ("start", "min", "max", "nominal"):
        if key in v.attributes and not math.isfinite(v.number(key)):
            yield f"{v.name}: {key} = {v.attributes[key]!r} is no finite number"
    if low > high:
        yield f"{v.name}: min = {low:.9g} is above max = {high:.9g}"
    start = v.number("start", math.nan)
    if start < low or start > high:
        yield f"{v.name}: start = {start:.9g}, outside {low:.9g} to {high:.9g}"
    if v.number("nominal", 1.0) <= 0:
        yield f"{v.name}: nominal = {v.number('nominal'):.9g}, must be above zero"


def _aliases(subject: Subject) -> Iterator[str]:
    """Variables that share a value reference: one of them at most can be set."""
    sets: dict[tuple[str, str], list[Scalar]] = {}
    for variable in subject.variables:
        kind = "Integer" if variable.kind == "Enumeration" else variable.kind
        sets.setdefault((kind, variable.reference), []).append(variable)
    for (_, reference), members in sets.items():
        settable = [v.name for v in members if v.causality in ("input", "parameter")]
        if len(settable) > 1:
            yield f"{settable[0]} and {settable[1]} share value reference {reference}"
        if {v.variability for v in members} >= {"constant", "fixed"}:
            yield f"{members[0].name}: constant and fixed variables share reference {reference}"
        outputs = [v.name for v in members if v.causality == "output"]
        if subject.ours and (len(outputs) > 1 or (outputs and settable)):
            other = next(v.name for v in members if v.name != outputs[0])
            yield f"{outputs[0]} shares value reference {reference} with {other}"


def _units(subject: Subject) -> Iterator[str]:
    defined: dict[str, set[str]] = {}
    for element in subject.root.iterfind("UnitDefinitions/Unit"):
        name = element.get("name", "")
        if name in defined:
            yield f"unit {name} is defined twice"
        defined[name] = {str(d.get("name")) for d in element.iterfind("DisplayUnit")}
        base = element.find("BaseUnit")
        if base is not None:
            yield from _exponents(name, {str(k): str(v) for k, v in base.attrib.items()})
        for shown in element.iterfind("DisplayUnit"):
            factor = shown.get("factor", "1")
            if not math.isfinite(parsed(factor)) or parsed(factor) == 0:
                yield f"unit {name}: display unit {shown.get('name')} has factor {factor}"
                continue
            usual = dict(UNITS[name].display).get(str(shown.get("name"))) if name in UNITS else None
            if usual is not None and not math.isclose(parsed(factor), usual, rel_tol=1e-6):
                yield f"unit {name}: 1 {name} is {usual:.9g} {shown.get('name')}, not {factor}"
    types = {
        str(t.get("name")): str(t.find("Real").get("unit"))  # type: ignore[union-attr]
        for t in subject.root.iterfind("TypeDefinitions/SimpleType")
        if t.find("Real") is not None
    }
    for variable in subject.variables:
        inherited = types.get(variable.attributes.get("declaredType", ""), "")
        name = variable.attributes.get("unit", inherited)
        display = variable.attributes.get("displayUnit")
        if "unit" in variable.attributes and name not in defined:
            yield f"{variable.name}: unit {name!r} is not among the UnitDefinitions"
        elif display and display not in defined.get(name, set()) | {name}:
            yield f"{variable.name}: display unit {display!r} does not belong to unit {name!r}"


def _exponents(name: str, base: dict[str, str]) -> Iterator[str]:
    """A unit whose name is plain SI must be what its name says; rad may be left out."""
    try:
        wanted = unit(name, name).exponents
    except InterfaceError:
        return
    factor, offset = parsed(base.pop("factor", "1")), parsed(base.pop("offset", "0"))
    given = {k: parsed(v) for k, v in base.items() if parsed(v) and k != "rad"}
    if given != {k: v for k, v in wanted.items() if k != "rad"} or (factor, offset) != (1, 0):
        yield f"unit {name} is defined as something else: {base}, factor {factor:g}"


def _types(subject: Subject) -> Iterator[str]:
    declared = {str(t.get("name")) for t in subject.root.iterfind("TypeDefinitions/SimpleType")}
    for variable in subject.variables:
        used = variable.attributes.get("declaredType")
        if used is not None and used not in declared:
            yield f"{variable.name}: declared type {used!r} is not among the TypeDefinitions"
    for simple in subject.root.iterfind("TypeDefinitions/SimpleType"):
        for key in ("name", "value"):
            items = Counter(i.get(key, "") for i in simple.iterfind("Enumeration/Item"))
            for text, count in items.items():
                if count > 1 or not text.strip():
                    yield f"type {simple.get('name')}: {count} items have the {key} {text!r}"


def _sample_time(subject: Subject) -> Iterator[str]:
    """The sample time is a whole number of the steps that the FMU asks for."""
    variable = next((v for v in subject.variables if v.name == "Ts"), None)
    experiment = subject.root.find("DefaultExperiment")
    step = math.nan if experiment is None else parsed(experiment.get("stepSize"))
    if variable is None or not step > 0:
        yield "no sample time Ts or no DefaultExperiment stepSize"
        return
    value = variable.number("start")
    ratio = value / step
    # written so that what is no number is blamed too
    if not (0.5 < ratio < 2**53 and abs(ratio - round(ratio)) < 1e-6):
        yield f"Ts = {value:.9g} s is {ratio:.6g} steps of {step:.9g} s: not whole"

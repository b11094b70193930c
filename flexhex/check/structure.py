"""ModelStructure, capability flags and the rest of a modelDescription.xml."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterator

from lxml import etree

from flexhex.check.subject import Subject, parsed
from flexhex.fmugen.description import LOG_CATEGORIES

IDENTIFIER = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
KINDS = {"dependent", "constant", "fixed", "tunable", "discrete"}


def structure(subject: Subject) -> Iterator[str]:
    """Complaints about everything but the variables themselves."""
    yield from _identity(subject)
    yield from _experiment(subject.root)
    yield from _outputs(subject)
    for part in ("Outputs", "Derivatives", "InitialUnknowns"):
        yield from _unknowns(subject, part)
    yield from _flags(subject)


def _identity(subject: Subject) -> Iterator[str]:
    if not subject.root.get("guid"):
        yield "guid is empty: a binary cannot be told from that of another build"
    kinds = ("CoSimulation",) if subject.ours else ("CoSimulation", "ModelExchange")
    if all(subject.root.find(tag) is None for tag in kinds):
        yield f"modelDescription.xml has no element {' or '.join(kinds)}: nothing can be run"
    for tag in ("CoSimulation", "ModelExchange"):
        for element in subject.root.iterfind(tag):
            name = element.get("modelIdentifier", "")
            if not IDENTIFIER.fullmatch(name):
                yield f"modelIdentifier {name!r} is no C identifier"
    encoding = subject.root.getroottree().docinfo.encoding
    if encoding and encoding.upper() not in ("UTF-8", "US-ASCII", "ASCII"):
        yield f"modelDescription.xml is written in {encoding}, FMI 2.0 wants UTF-8"
    names = [str(e.get("name")) for e in subject.root.iterfind("LogCategories/Category")]
    for name, count in Counter(names).items():
        if count > 1:
            yield f"log category {name} is declared {count} times"
    if subject.ours and names != list(LOG_CATEGORIES):
        yield f"log categories {', '.join(names) or 'none'}: not those of this adapter"


def _experiment(root: etree._Element) -> Iterator[str]:
    experiment = root.find("DefaultExperiment")
    if experiment is None:
        return
    values = {str(k): parsed(str(v)) for k, v in experiment.attrib.items()}
    for key, value in values.items():
        if not math.isfinite(value):
            yield f"DefaultExperiment {key} = {experiment.get(key)!r} is no finite number"
        elif key in ("stepSize", "tolerance") and value <= 0:
            yield f"DefaultExperiment {key} = {value:.9g}, must be above zero"
    if values.get("stopTime", float("inf")) < values.get("startTime", 0.0):
        yield "DefaultExperiment ends before it starts"


def _outputs(subject: Subject) -> Iterator[str]:
    listed = [u.get("index", "") for u in subject.root.iterfind("ModelStructure/Outputs/Unknown")]
    outputs = {str(v.index): v.name for v in subject.variables if v.causality == "output"}
    known = set(listed)
    for index, name in outputs.items():
        if index not in known:
            yield f"output {name} is missing in ModelStructure/Outputs"
    for index in listed:
        if index not in outputs:
            yield f"ModelStructure/Outputs lists index {index}, which is no output"
    for index, count in Counter(listed).items():
        if count > 1:
            yield f"ModelStructure/Outputs lists index {index} {count} times"


def _unknowns(subject: Subject, part: str) -> Iterator[str]:
    """Indices exist, dependencies are known variables in ascending order."""
    known = {str(v.index): v for v in subject.variables}
    for element in subject.root.iterfind(f"ModelStructure/{part}/Unknown"):
        index, words = element.get("index", ""), element.get("dependencies", "").split()
        if index not in known:
            yield f"ModelStructure/{part}: there is no variable with index {index}"
            continue
        name = known[index].name
        for word in words:
            if word not in known:
                yield f"{name} depends on index {word} ({part}), which no variable has"
            elif part == "Outputs" and known[word].causality == "output":
                yield f"{name} depends on the output {known[word].name}: only inputs and states"
        numbers = [int(w) for w in words if w.isdigit()]
        if numbers != sorted(set(numbers)):
            yield f"{name}: dependencies ({part}) are not in ascending order, or doubled"
        kinds = element.get("dependenciesKind")
        if kinds is not None and len(kinds.split()) != len(words):
            yield f"{name}: {len(kinds.split())} kinds for {len(words)} dependencies ({part})"
        elif kinds is not None and not set(kinds.split()) <= KINDS:
            yield f"{name}: dependenciesKind {kinds!r} is unknown to the standard"


def _flags(subject: Subject) -> Iterator[str]:
    """Capability flags that contradict each other; the binary is tried elsewhere."""
    element = subject.cosimulation
    if element is None:
        return
    true = {str(k) for k, v in element.attrib.items() if v in ("true", "1")}
    if "canSerializeFMUstate" in true and "canGetAndSetFMUstate" not in true:
        yield "canSerializeFMUstate without canGetAndSetFMUstate"
    if subject.ours and "canRunAsynchronuously" in true:
        yield "canRunAsynchronuously is true, but every step is complete when fmi2DoStep returns"

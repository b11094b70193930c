"""`flexhex check` of an FMU: archive, description, and whether the binary keeps its word."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from flexhex.check.archive import archive
from flexhex.check.binary import binary
from flexhex.check.results import deviating
from flexhex.check.sources import sources
from flexhex.check.structure import structure
from flexhex.check.subject import Subject
from flexhex.check.variables import variables

MOST = 10
"""Complaints of each stage that are shown: one mistake can stand in every variable."""


def check_fmu(path: Path, run: bool = True) -> list[str]:
    """Complaints about an FMU, each a sentence; run: compile its sources, exercise its binary."""
    subject = Subject.open(path)
    version = subject.root.get("fmiVersion")
    if version is None:
        return [f"{path}: modelDescription.xml has no fmiVersion: not the description of an FMU"]
    stages: list[list[str]] = []
    if version == "2.0":
        stages = [list(stage(subject)) for stage in (archive, structure, variables)]
    stages.append(list(_fmpy(path, any(stages))))
    if version == "2.0" and run and subject.cosimulation is not None:
        stages += [list(sources(subject)), binary(subject)]
        # where something else is wrong, results would only say so again
        stages.append([] if any(stages) else deviating(subject))
    return [f"{path}: {text}" for stage in stages for text in _some(list(dict.fromkeys(stage)))]


def _some(texts: list[str]) -> list[str]:
    more = len(texts) - MOST
    return [*texts[:MOST], f"... and {more} more"] if more > 0 else texts


def _fmpy(path: Path, known: bool) -> Iterator[str]:
    """What FMPy's own validation finds: schema and consistency. Names are checked elsewhere: its
    grammar takes minutes for many. known: something was found already."""
    from fmpy.model_description import ValidationError, read_model_description

    try:
        read_model_description(str(path), validate=True, validate_model_structure=True)
    except ValidationError as error:
        yield from (" ".join(str(text).split()) for text in error.problems)
    except Exception as error:  # FMPy raises plain Exception for what it understands
        text = " ".join(str(error).split())
        if type(error) is Exception and text:
            yield text
        elif not known:  # it stopped at what has been named
            yield _stumbled(error)


def _stumbled(error: Exception) -> str:
    """What FMPy stopped at, where its own message is that of a programming error."""
    text = "modelDescription.xml: not as FMI 2.0 wants it, FMPy cannot read it"
    if isinstance(error, KeyError):
        return f"{text}: it refers to {error}, which it does not declare"
    return f"{text}: an element or an attribute is missing ({type(error).__name__})"

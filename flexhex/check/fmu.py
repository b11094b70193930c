"""`flexhex check` of an FMU: archive, description, and whether the binary keeps its word."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from flexhex.check.archive import archive
from flexhex.check.binary import binary
from flexhex.check.structure import structure
from flexhex.check.subject import Subject
from flexhex.check.variables import variables

MOST = 10
"""Complaints of FMPy that are shown: one mistake can stand in every variable."""


def check_fmu(path: Path, run: bool = True) -> list[str]:
    """Complaints about an FMU, each a sentence; run: exercise its binary in a child process."""
    subject = Subject.open(path)
    version = subject.root.get("fmiVersion")
    found = list(_fmpy(path))
    if version == "2.0":
        found += [*archive(subject), *structure(subject), *variables(subject)]
        if run and subject.cosimulation is not None:
            found += binary(subject)
    return [f"{path}: {text}" for text in dict.fromkeys(found)]


def _fmpy(path: Path) -> Iterator[str]:
    """What FMPy's own validation finds: schema and consistency."""
    from fmpy.validation import validate_fmu

    try:
        texts = [" ".join(str(text).split()) for text in validate_fmu(str(path))]
        yield from texts[:MOST]
        if len(texts) > MOST:
            yield f"... and {len(texts) - MOST} more of this kind"
    except Exception as error:  # FMPy raises plain Exception for what it understands
        text = (str(error).splitlines() or [""])[0]
        yield text if type(error) is Exception and text else _stumbled(error)


def _stumbled(error: Exception) -> str:
    """What FMPy stopped at, where its own message is that of a programming error."""
    text = "modelDescription.xml: not as FMI 2.0 wants it, FMPy cannot read it"
    if isinstance(error, KeyError):
        return f"{text}: it refers to {error}, which it does not declare"
    return f"{text}: an element or an attribute is missing ({type(error).__name__})"

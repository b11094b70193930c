"""`flexhex check --results`: does an FMU still answer as it did when it was built?

The FMU carries inputs and outputs (`flexhex.fmugen.recorded`). Its binary for this computer runs
on them in a child process; the worst deviation of each output is reported.
"""

from __future__ import annotations

import csv
import io
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexhex.check.binary import SUFFIXES, exercised, library_name, make_plan, place
from flexhex.check.subject import Subject
from flexhex.fmugen.recorded import IN, OUT
from flexhex.fmus.common.errors import InterfaceError
from flexhex.fmus.common.interface import array_of

RTOL, ATOL = 1e-9, 1e-14
"""Of an array's largest value, and for what is zero but for rounding: compilers and C libraries
differ in the last bit of sines and roots; an equation that changed differs by more."""


@dataclass(frozen=True)
class Deviation:
    """Worst deviation of an output (an array as one) [unit], where and how much is allowed."""

    output: str
    worst: float
    allowed: float
    time: float

    @property
    def good(self) -> bool:
        """Within tolerance; nan is not."""
        return self.worst <= self.allowed


def deviating(subject: Subject) -> list[str]:
    """Complaints about outputs that differ from the results that an FMU of ours carries."""
    if not subject.ours or IN not in subject.names or library_name(subject) is None:
        return []
    try:
        deviations = _deviations_of(subject)
    except InterfaceError as error:
        return [str(error).removeprefix(f"{subject.path}: ")]
    return [
        f"{d.output} is off by {d.worst:.3g} at {d.time:.9g} s from what {OUT} holds"
        for d in deviations
        if not d.good
    ]


def check_results(path: Path) -> list[Deviation]:
    """Deviations of all outputs. InterfaceError without results, binary or an answer."""
    return _deviations_of(Subject.open(path))


def _deviations_of(subject: Subject) -> list[Deviation]:
    path, name = subject.path, library_name(subject)
    if IN not in subject.names or OUT not in subject.names:
        raise InterfaceError(f"{path}: carries no reference results ({IN}, {OUT})")
    if name is None:
        raise InterfaceError(f"{path}: has no binary for this computer")
    inputs, given = _table(subject, IN)
    outputs, wanted = _table(subject, OUT)
    with tempfile.TemporaryDirectory() as folder, subject.archive() as archive:
        archive.extractall(folder)
        plan = make_plan(subject, Path(folder), name)
        listed = [v for v in subject.variables if v.reference.isdigit() and v.kind in SUFFIXES]
        references = {v.name: place(v) for v in listed}
        unknown = [n for n in (*inputs, *outputs) if n not in references]
        if unknown:
            raise InterfaceError(f"{path}: reference results of {unknown[0]}, no such variable")
        declared = {v.name for v in subject.variables if v.causality == "input"}
        other = sorted(set(inputs) ^ declared)
        if other:
            raise InterfaceError(
                f"{path}: {other[0]} is an input in one of {IN} and the description, not in both"
            )
        plan["play"] = {
            "inputs": [references[n] for n in inputs],
            "outputs": [references[n] for n in outputs],
            "rows": given[:, 1:].tolist(),
            "times": [*given[:, 0].tolist(), float(wanted[-1, 0])],
        }
        rows = _played(plan, path)
    if len(rows) != len(wanted):
        raise InterfaceError(f"{path}: stopped after {len(rows)} of {len(wanted)} steps")
    return _deviations(outputs, np.array(rows), wanted)


def _table(subject: Subject, name: str) -> tuple[list[str], NDArray[np.float64]]:
    """Names without `time`, and rows with it in front."""
    try:
        names, *rows = csv.reader(io.StringIO(subject.read(name).decode()))
        if not rows:
            raise ValueError
        return names[1:], np.array(rows, dtype=float).reshape(-1, len(names))
    except ValueError as error:
        raise InterfaceError(f"{subject.path}: {name}: not a table of numbers") from error


def _played(plan: dict[str, Any], path: Path) -> list[list[float]]:
    said, ended = exercised(plan)
    complaints = [text for kind, text in said if kind in ("complaint", "note")]
    if ended or complaints:
        raise InterfaceError(f"{path}: {complaints[0] if complaints else f'the binary {ended}'}")
    return [row for kind, row in said if kind == "row"]


def _deviations(
    names: Sequence[str], rows: NDArray[np.float64], wanted: NDArray[np.float64]
) -> list[Deviation]:
    arrays = np.array([array_of(name) for name in names])
    deviations = []
    for array in dict.fromkeys(arrays):
        mine, theirs = rows[:, arrays == array], wanted[:, 1:][:, arrays == array]
        apart = np.abs(mine - theirs)
        at = int(np.argmax(np.where(np.isnan(apart), np.inf, apart).max(axis=1)))
        worst = float(apart.max())  # nan where there is one
        allowed = RTOL * float(np.abs(theirs).max()) + ATOL
        deviations.append(Deviation(str(array), worst, allowed, float(wanted[at, 0])))
    return deviations


def print_deviations(compared: Mapping[Path, Sequence[Deviation]]) -> None:
    """Worst deviation of each output from the results that the FMU carries."""
    for path, deviations in compared.items():
        bad = sum(not d.good for d in deviations)
        print(f"{path}: {f'{bad} outputs beyond tolerance' if bad else 'as when it was built'}")
        width = max(len(d.output) for d in deviations)
        for d in deviations:
            mark = "" if d.good else f"  BEYOND, at {d.time:.9g} s"
            print(f"  {d.output:{width}}  {d.worst:.3g}, allowed {d.allowed:.3g}{mark}")

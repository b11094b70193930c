"""`identify --write FILE`: a machine file with the fitted values (.toml), or all of p with its
standard deviations (.csv, .json).

A machine file holds one upper arm, one lower arm and one end-effector by mass, centre and inertia,
p holds what acts alike: the lower arm's mass and mc_x stay the file's, all else takes the fitted
difference. What is not determined, what the file has no place for and bodies whose fitted inertia
no body can have keep the file's values; the others are the best fit beside these,

    p' = p + C A^T (A C A^T)^-1 (A p_file - A p)      C: covariance of p, A: what is kept
"""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from flexhex.diagnose.options import refuse_unwritable
from flexhex.diagnosis.estimation.identify import Fit
from flexhex.diagnosis.machine_files.machine_changes import changed_sections
from flexhex.diagnosis.machine_files.toml_text import toml_text
from flexhex.diagnosis.result.estimates import Estimate
from flexhex.diagnosis.result.verdict import Changed
from flexhex.fmus.common.errors import UsageError
from flexhex.fmus.common.interface import array_of
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.machine_file import load_machine, machine_data
from flexhex.fmus.common.model.bodies import INERTIA_NAMES, inertia, nominal_mechanism
from flexhex.fmus.common.model.parameters import base_parameters, parameters
from flexhex.identify.view import fit_json

BODIES = {"upper", "lower", "end_effector"}
KINDS = (".toml", ".csv", ".json")


def checked_target(path: Path, machine_file: Path) -> None:
    """UsageError or OutputError, before anything is computed, for a file that cannot be written."""
    if path.suffix not in KINDS:
        raise UsageError(
            f"--write {path}: write .toml for a machine file, .csv or .json for all values with"
            " their standard deviations"
        )
    if path.resolve() == machine_file.resolve():
        raise UsageError(f"--write {path}: is the machine file itself: name another file")
    refuse_unwritable(path, "--write")


def write_fit(
    path: Path, machine_file: Path, machine: Machine, fit: Fit, logs: Sequence[Path]
) -> list[str]:
    """Write the fit; what the file cannot hold, in sentences. MachineError when the fitted values
    make no machine."""
    if path.suffix == ".csv":
        path.write_text(_csv(machine, fit), encoding="utf-8")
    elif path.suffix == ".json":
        path.write_text(fit_json(machine, fit) + "\n", encoding="utf-8")
    else:
        return _machine(path, machine_file, machine, fit, logs)
    return []


def _csv(machine: Machine, fit: Fit) -> str:
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(("name", "unit", "value", "std"))
    for par, value, std in zip(parameters(machine), fit.p, fit.std, strict=True):
        table.writerow((par.name, par.unit, repr(float(value)), repr(float(std))))
    return text.getvalue()


def _machine(
    path: Path, machine_file: Path, machine: Machine, fit: Fit, logs: Sequence[Path]
) -> list[str]:
    data, kept = machine_data(machine_file), kept_names(machine, fit)
    while True:
        near = beside(machine, fit, kept)
        sections, refused = changed_sections(data, changes(machine, near, kept))
        if not refused:
            break
        kept |= stays(machine, {text.partition(" from ")[0] for text in refused})
    source = ", ".join(log.name for log in logs)
    for section in sections.values():
        _mark(section, f"least squares from {source}")
    base = Path(os.path.relpath(machine_file.resolve(), path.resolve().parent)).as_posix()
    names = [par.name for par in parameters(machine) if par.name in kept]
    text = [f"kept as {machine_file.name} has them: {', '.join(names)}"] if names else []
    head = [f"{machine.name} with parameters fitted to {source} by flexhex identify.", *text]
    path.write_text(toml_text({"extends": base, **sections}, {}, head), encoding="utf-8")
    load_machine(path)
    return text


def kept_names(machine: Machine, fit: Fit) -> set[str]:
    """What keeps the file's value at first: parameters that are not determined, effects' gains."""
    return {*fit.undetermined, *(par.name for par in parameters(machine) if par.body == "effects")}


def stays(machine: Machine, refused: set[str]) -> set[str]:
    """What keeps the file's value when these parameters are refused: a body as a whole."""
    bodies = {body_of(name) for name in refused} & BODIES
    names = [par.name for par in parameters(machine)]
    return {name for name in names if name in refused or body_of(name) in bodies}


def body_of(name: str) -> str:
    """`upper` of `upper.J[3]`."""
    return array_of(name)


def beside(machine: Machine, fit: Fit, kept: set[str]) -> Fit:
    """The best fit with the machine file's values for `kept`, and with upper arms that are alike.

    ValueError where the fit has no covariance.
    """
    if fit.covariance is None:
        raise ValueError("a fit without covariance")
    listed, file = parameters(machine), base_parameters(machine)
    unit = np.eye(len(listed))
    arms = [k for k, par in enumerate(listed) if par.name.startswith("upper.J[")]
    rows = [unit[k] for k, par in enumerate(listed) if par.name in kept]
    if not all(listed[k].name in kept for k in arms):
        arms = [k for k in arms if listed[k].name not in kept]
        rows += [unit[k] - unit[arms[0]] for k in arms[1:]]
    if not rows:
        return fit
    A, C = np.array(rows), fit.covariance
    gain = np.linalg.solve(A @ C @ A.T, A @ C).T
    return replace(fit, p=fit.p + gain @ (A @ (file - fit.p)), covariance=C - gain @ A @ C)


def changes(machine: Machine, fit: Fit, kept: set[str]) -> list[Changed]:
    """Each fitted parameter but the kept ones as a change of what the machine file says of it.

    Inertias of p are regrouped: what changes is the file's own value by the fitted difference.
    """
    own, changed, listed = _own_values(machine), list[Changed](), parameters(machine)
    shift = fit.p - base_parameters(machine)
    for par, moved in zip(listed, shift, strict=True):
        name = "upper.J" if par.name == "upper.J[1]" else par.name
        if par.name not in kept and name in own:
            value = float(own[name] + moved)
            changed.append(Changed(name, own[name], Estimate(value, (value, value), par.unit)))
    return changed


def _own_values(machine: Machine) -> dict[str, float]:
    """The machine file's values by the names of p, not regrouped: about each body's origin."""
    full = nominal_mechanism(machine)
    J, mc_x, mc_z = (float(v) for v in np.array(full.upper[0]).ravel())
    own = {"upper.J": J, "upper.mc_x": mc_x, "upper.mc_z": mc_z}
    if machine.has_platform:
        bodies = {
            "lower": inertia(machine.platform.lower),
            "end_effector": inertia(machine.platform.end_effector),
        }
        for body, ten in bodies.items():
            own |= {f"{body}.{n}": float(v) for n, v in zip(INERTIA_NAMES, ten, strict=True)}
    listed = zip(parameters(machine), base_parameters(machine), strict=True)
    others = {par.name: float(v) for par, v in listed if not par.name.startswith("upper.J[")}
    return others | own


def _mark(table: Any, note: str) -> None:
    """Say of every fitted quantity where it is from."""
    if isinstance(table, dict) and "value" in table:
        if table.get("source") == "diagnosed":
            table.update(source="fitted", note=note)
    elif isinstance(table, dict):
        for below in table.values():
            _mark(below, note)

"""Changed parameters of a diagnosis put into the sections of a machine file.

A file holds the torque terms of every actuator, and one upper arm, one lower arm, one end-effector
and one set of flexures for all arms, each body as mass, centre and inertia about its centre.
"""

from __future__ import annotations

import copy
import re
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ValidationError

from flexhex.diagnosis.kinds import with_unit
from flexhex.diagnosis.result.verdict import Changed
from flexhex.fmus.common.machine.sections import Actuator, Body, EndEffector, Flexures, UpperArm
from flexhex.fmus.common.model.bodies import INERTIA_NAMES, STIFFNESS_NAMES, inertia, point_mass
from flexhex.fmus.common.model.parameters import ACTUATOR

Array = NDArray[np.float64]
Data = dict[str, Any]
_AXIS = re.compile(rf"{ACTUATOR}\[(\d+)\]\.([okdc])")
_COGGING = re.compile(rf"{ACTUATOR}\[(\d+)\]\.([ab])\[(\d+)\]")
_BODIES: Mapping[str, type[Body]] = {
    "upper": UpperArm,
    "lower": Body,
    "end_effector": EndEffector,
}


def changed_sections(data: Data, changes: Sequence[Changed]) -> tuple[Data, list[str]]:
    """Sections of `data` (plain data of a machine file) with the changes in them, and what no
    machine file can hold, in words. Changes of one body go in together."""
    data, left_out, touched = copy.deepcopy(data), list[str](), set[str]()
    for body in _BODIES:
        mine = [c for c in changes if re.fullmatch(rf"{body}\.\w+", c.parameter)]
        if mine:
            trial = copy.deepcopy(data)
            trouble = _try(lambda t=trial, b=body, m=mine: _body(t, b, m))  # type: ignore[misc]
            data, touched = (data, touched) if trouble else (trial, touched | {"bodies"})
            left_out += [f"{_text(c)} ({trouble})" for c in mine if trouble]
    for change in (c for c in changes if c.parameter.partition(".")[0] not in _BODIES):
        trial = copy.deepcopy(data)
        section = "flexures" if change.parameter.startswith("flexure") else "actuator"
        trouble = _try(lambda t=trial, c=change: _other(t, c))  # type: ignore[misc]
        data, touched = (data, touched) if trouble else (trial, touched | {section})
        left_out += [f"{_text(change)} ({trouble})"] if trouble else []
    return {name: data[name] for name in data if name in touched}, left_out


def _text(change: Changed) -> str:
    e = change.estimate
    text = f"{change.parameter} from {change.nominal:.6g} to {e.value:.6g}"
    return with_unit(text, e.unit)


def _try(act: Callable[[], None]) -> str:
    """What stands against a change, or nothing."""
    try:
        act()
    except ValidationError as error:
        return str(error.errors()[0]["msg"]).removeprefix("Value error, ")
    except (LookupError, ValueError) as error:
        return str(error).strip("'\"")
    return ""


def _check(section: type[BaseModel], table: Any) -> None:
    section.model_validate(table)


def _put(table: Data, key: str, value: Any, note: str) -> None:
    entry = {k: v for k, v in table[key].items() if k not in ("note", "ci95")}
    table[key] = {**entry, "value": value, "source": "diagnosed", "note": note}


def _other(data: Data, change: Changed) -> None:
    """A torque term of an actuator, or the stiffness that all arms share."""
    value, name = change.estimate.value, change.parameter
    low, high = change.estimate.ci95
    if match := _AXIS.fullmatch(name):
        values = list(data["actuator"][match[2]]["value"])
        values[int(match[1]) - 1] = value
        note = f"{name} was {change.nominal:.6g}, 95 % {low:.6g} to {high:.6g}"
        _put(data["actuator"], match[2], values, note)
        _check(Actuator, data["actuator"])
    elif match := _COGGING.fullmatch(name):
        rows = [list(row) for row in data["actuator"][match[2]]["value"]]
        rows[int(match[1]) - 1][int(match[3]) - 1] = value
        note = f"{name} was {change.nominal:.6g}, 95 % {low:.6g} to {high:.6g}"
        _put(data["actuator"], match[2], rows, note)
        _check(Actuator, data["actuator"])
    elif name.startswith("flexure.") and name.partition(".")[2] in STIFFNESS_NAMES:
        at = STIFFNESS_NAMES.index(name.partition(".")[2])
        key = ("k_u", "k_s")[at // 2]
        values = list(data["flexures"][key]["value"])
        values[at % 2] = value
        note = f"{name} was {change.nominal:.6g}, 95 % {low:.6g} to {high:.6g}"
        _put(data["flexures"], key, values, note)
        _check(Flexures, data["flexures"])
    elif re.match(r"(upper|lower|flexure)\[\d+\]\.", name):
        raise LookupError("a machine file has one such part for all arms: not written")
    elif name.startswith("arm"):
        raise LookupError("the loops must close at neutral: not written")
    else:
        raise LookupError("a machine file has no place for it")


def _body(data: Data, name: str, changes: Sequence[Changed]) -> None:
    """Entries of a body's ten inertias about its origin, as m, c and Ic.

    A changed mass of the end-effector alone is a point mass at c_payload. The upper arm's J is
    that about the motor axis, rotor included: the rotor takes what the arm does not.
    """
    table, model = data["bodies"][name], _BODIES[name]
    before = model.model_validate(table)
    ten = np.array(inertia(before), dtype=float)
    rotor = before.J_rotor if isinstance(before, UpperArm) else 0.0
    wanted = {c.parameter.partition(".")[2]: c.estimate.value for c in changes}
    if isinstance(before, EndEffector) and set(wanted) == {"m"}:
        ten += np.array(point_mass(wanted["m"] - ten[0], before.c_payload), dtype=float).ravel()
        ten[0] = wanted["m"]
    J = wanted.pop("J", None)
    about = float(ten[5]) + rotor
    for entry, value in wanted.items():
        ten[INERTIA_NAMES.index(entry)] = value
    m, c = float(ten[0]), ten[1:4] / ten[0]
    full = np.array([[ten[4], ten[7], ten[8]], [ten[7], ten[5], ten[9]], [ten[8], ten[9], ten[6]]])
    Ic = full - m * (c @ c * np.eye(3) - np.outer(c, c))
    six = [float(Ic[i, j]) for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
    note = "; ".join(f"{c.parameter} was {c.nominal:.6g}" for c in changes)
    if set(wanted):
        _put(table, "m", m, note)
        _put(table, "c", [float(v) for v in c], note)
        _put(table, "Ic", six, note)
    if isinstance(before, UpperArm):
        left = (about if J is None else J) - float(ten[5])
        _put(table, "J_rotor", left, note)
    _check(model, table)

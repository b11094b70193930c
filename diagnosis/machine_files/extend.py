"""What a diagnosis found, as a new machine file that extends the one it was asked about.

    extends = "../machines/tflex.toml"
    diagnosed = true

    [[effects]]
    id = "coulomb_friction"
    axes = [2, 5]
    [effects.parameters]
    F_c = { value = [0.05, 0.04], unit = "N m", source = "diagnosed", ci95 = [[...], [...]] }

`machine_changes.py` puts changed parameters into their sections.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from flexhex.diagnosis.machine_files.machine_changes import changed_sections
from flexhex.diagnosis.machine_files.toml_text import toml_text
from flexhex.diagnosis.result.estimates import Estimate
from flexhex.diagnosis.result.verdict import Diagnosis, Named
from flexhex.fmus.common.effects import Effect, library
from flexhex.fmus.common.effects.own import own_effect
from flexhex.fmus.common.machine.effect_use import EffectUse
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.machine_file import load_machine, machine_data
from flexhex.fmus.common.user_code import relative

SOURCE = "diagnosed"
Entry = dict[str, Any]


@dataclass(frozen=True)
class Extended:
    """The new machine file, and sentences about what a machine file cannot hold."""

    path: Path
    left_out: tuple[str, ...]


@dataclass(frozen=True)
class AxisEstimates:
    """An effect on one axis (0: the whole machine): its estimates by plain name."""

    axis: int
    estimates: Mapping[str, Estimate]

    def shape(self, effect: Effect) -> tuple[float, ...]:
        """Values of its shapes in the library's order, of those left out what that means."""
        known = {name: estimate.value for name, estimate in self.estimates.items()}
        return tuple(known.get(shape.name, shape.start) for shape in effect.shapes)

    def plus(self, other: AxisEstimates, effect: Effect) -> AxisEstimates:
        """The same effect with the gains of both."""
        both = dict(self.estimates)
        for gain in effect.gains:
            a, b = self.estimates[gain.name], other.estimates[gain.name]
            ci = (a.ci95[0] + b.ci95[0], a.ci95[1] + b.ci95[1])
            both[gain.name] = Estimate(a.value + b.value, ci, a.unit)
        return AxisEstimates(self.axis, both)


def extended_file(machine_file: Path, diagnosis: Diagnosis, out: Path) -> Path:
    """Write what was found to `out`, a machine file that extends `machine_file`; see `extend`."""
    return extend(machine_file, diagnosis, out).path


def extend(machine_file: Path, diagnosis: Diagnosis, out: Path) -> Extended:
    """Write what was found to `out`; what the format cannot hold is returned and noted there.

    Effects that the machine has already keep their entries; one that was found again with the
    same shape on the same axis grows by what was found. Raises MachineError when the result
    is no machine.
    """
    data, machine = machine_data(machine_file), load_machine(machine_file)
    lasting = [change for change in diagnosis.changed if not change.runs]
    sections, left_out = changed_sections(data, lasting)
    known = [dict(entry) for entry in data.get("effects", [])]
    new: list[Entry] = []
    for named in diagnosis.effects:
        entries, refused = _entries(named, known, machine)
        new += entries
        left_out += refused
    base = os.path.relpath(machine_file.resolve(), out.resolve().parent)
    head = [
        f"What a diagnosis added to {machine_file.name}: {diagnosis.verdict}.",
        *(
            f"From {', '.join(Path(run).name for run in diagnosis.runs)}."
            for _ in diagnosis.runs[:1]
        ),
        *(f"Not in here: {text}" for text in left_out),
    ]
    text = toml_text(
        {"extends": Path(base).as_posix(), "diagnosed": True, **sections},
        {"effects": [_seen_from(out.parent, e) for e in known + new]} if diagnosis.effects else {},
        head,
    )
    out.parent.mkdir(parents=True, exist_ok=True)
    out.write_text(text, encoding="utf-8")
    load_machine(out)
    return Extended(out, tuple(left_out))


def effect_of(named: Named) -> Effect:
    """The effect that was named, of the library or the user's own."""
    return own_effect(named.origin, "--effect") if named.origin else library()[named.id]


def _id(effect: Effect) -> str:
    """How a machine file calls it."""
    return effect.origin or effect.id


def _seen_from(folder: Path, entry: Entry) -> Entry:
    """An entry for a machine file in a folder."""
    return entry | {"id": relative(entry["id"], folder)}


def _entries(named: Named, known: list[Entry], machine: Machine) -> tuple[list[Entry], list[str]]:
    """Entries of one effect, one for each shape, beside what does not fit; `known` ones grow."""
    effect, refused = effect_of(named), []
    by_shape: dict[tuple[float, ...], dict[int, AxisEstimates]] = {}
    for axis, estimates in named.parts:
        possible = {**estimates, **_bounded(effect, estimates)}
        part = AxisEstimates(axis, possible | _given_way(effect, possible, machine.softest))
        trouble = _trouble(effect, part, machine)
        if trouble:
            refused.append(trouble)
        elif not _grown(known, effect, part):
            beside = by_shape.setdefault(part.shape(effect), {})
            beside[axis] = beside[axis].plus(part, effect) if axis in beside else part
    entries = [_entry(named, effect, sorted(p.values(), key=_axis)) for p in by_shape.values()]
    return entries, refused


def _bounded(effect: Effect, estimates: Mapping[str, Estimate]) -> dict[str, Estimate]:
    """Gains that noise alone has pushed beyond their bounds, at the bound."""
    bounded = {}
    for gain in effect.gains:
        estimate = estimates[gain.name]
        value = min(max(estimate.value, gain.low), gain.high)
        if estimate.ci95[0] <= value <= estimate.ci95[1]:
            bounded[gain.name] = replace(estimate, value=value)
    return bounded


def _given_way(
    effect: Effect, estimates: Mapping[str, Estimate], softest: float
) -> dict[str, Estimate]:
    """The angle within which friction turns over, at least `softest` [rad/(N m)] of its torque:
    what runs cannot tell from a sign may be stiffer than the plant's steps integrate."""
    angle = estimates.get("s_0")
    if angle is None:
        return {}
    torque = sum(abs(estimates[g.name].value) for g in effect.gains if g.unit == "N m")
    return {"s_0": replace(angle, value=max(angle.value, softest * torque))}


def _axis(part: AxisEstimates) -> int:
    return part.axis


def _trouble(effect: Effect, part: AxisEstimates, machine: Machine) -> str:
    """Why a machine file cannot hold an effect, or nothing."""
    values = {name: estimate.value for name, estimate in part.estimates.items()}
    where = f"{effect.id} on axis {part.axis}" if part.axis else effect.id
    try:
        use = EffectUse.of(_id(effect), [part.axis] if part.axis else [], **values)
    except ValidationError as error:
        return f"{where}: {error.errors()[0]['msg'].removeprefix('Value error, ')}"
    steep = machine.too_steep(use)
    return f"{where}: {steep}" if steep else ""


def _grown(known: list[Entry], effect: Effect, part: AxisEstimates) -> bool:
    """Whether the machine has the effect with this shape on this axis: its gains grow."""
    for entry in known:
        axes = entry.get("axes", [0])
        tables = entry["parameters"]
        written = {name: table["value"] for name, table in tables.items()}
        shape = tuple(float(written.get(s.name, s.start)) for s in effect.shapes)
        if entry["id"] != _id(effect) or part.axis not in axes or shape != part.shape(effect):
            continue
        grown = {name: dict(table) for name, table in tables.items()}
        for gain in effect.gains:
            table, at = grown[gain.name], axes.index(part.axis)
            values = table["value"] if isinstance(table["value"], list) else None
            each = list(values) if values else [float(table["value"])] * len(axes)
            each[at] += part.estimates[gain.name].value
            table.update(value=each if part.axis else each[0], source=SOURCE)
            table.pop("ci95", None)
        entry["parameters"] = grown
        return True
    return False


def _entry(named: Named, effect: Effect, parts: Sequence[AxisEstimates]) -> Entry:
    note = f"share of the repeatable residual that it explains: {named.share:.2f}"
    if not math.isfinite(named.share):
        note = "named by a diagnosis"
    if named.rivals:
        note += f"; these data do not tell it from {', '.join(named.rivals)}"
    tables: dict[str, Any] = {}
    for gain in effect.gains:
        estimates = [part.estimates[gain.name] for part in parts]
        tables[gain.name] = _table(estimates, bool(parts[0].axis), note)
    for shape in (s for s in effect.shapes if s.name in parts[0].estimates):
        tables[shape.name] = _table([parts[0].estimates[shape.name]], False, "")
    axes = {"axes": [part.axis for part in parts]} if parts[0].axis else {}
    return {"id": _id(effect), **axes, "parameters": tables}


def _table(estimates: Sequence[Estimate], many: bool, note: str) -> Entry:
    table: Entry = {
        "value": [e.value for e in estimates] if many else estimates[0].value,
        "unit": estimates[0].unit,
        "source": SOURCE,
    }
    intervals = [list(e.ci95) for e in estimates]
    if all(math.isfinite(bound) for interval in intervals for bound in interval):
        table["ci95"] = intervals if many else intervals[0]
    return table | ({"note": note} if note else {})

"""What a diagnosis found, read for the identification that fits it beside a base model."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

from flexhex.diagnosis.estimation.changes import changes_of
from flexhex.diagnosis.estimation.extras import Extra, Extras
from flexhex.diagnosis.estimation.friction import PARAMETER
from flexhex.diagnosis.result.verdict import NORMAL
from flexhex.fmus.common.effects import Effect, library
from flexhex.fmus.common.errors import UsageError, unreadable

FOREIGN = "no effect of the library; if it is your own, name its file, --effect FILE.py:NAME"
"""Why an effect of another name is not fitted."""
NONE: Mapping[str, Effect] = MappingProxyType({})
"""No effects of the user's own."""


def read_diagnosis(path: Path, own: Mapping[str, Effect] = NONE) -> Extras:
    """Effects and changes of a diagnosis that a file keeps (`flexhex diagnose`, `diagnosis.json`);
    own: effects beside the library's, by id. UsageError for another file."""
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise UsageError(f"--diagnosis {unreadable(path, error)}") from None
    except ValueError:
        data = None
    return extras_of(data, f"--diagnosis {path}", own)


def extras_of(data: Any, where: str, own: Mapping[str, Effect] = NONE) -> Extras:
    """The same of a diagnosis as data; where: how it is called in an error."""
    try:
        effects = [
            (e["id"], list(e["axes"]), _values(e), _deviations(e), list(e["rivals"]))
            for e in data["effects"]
        ]
        changed = changes_of(data.get("changed", ()))
    except (ValueError, KeyError, TypeError, AttributeError):
        text = "is no diagnosis: name the diagnosis.json that `flexhex diagnose` wrote"
        raise UsageError(f"{where}: {text}") from None
    if not effects and not changed:
        note = f"the diagnosis names nothing that is missing (verdict `{data.get('verdict')}`)"
        return Extras(notes=(f"{note}: nothing is fitted beside",), where=where)
    known, listed, notes = {**library(), **own}, list[Extra](), list[str]()
    for id, axes, values, deviations, rivals in effects:
        effect = known.get(id)
        reason = FOREIGN if effect is None else _reason(effect)
        if reason or effect is None:
            notes.append(f"{id} is not fitted: {reason}")
            continue
        if rivals:
            notes.append(f"{id} is indistinguishable from {', '.join(rivals)}: it is fitted")
        if id in PARAMETER:
            continue
        for axis in axes:
            there = _on_axis(effect, axis, len(axes), values, deviations)
            listed += there
            if not there:
                notes.append(f"{id} is not fitted on axis {axis}: it has no values there")
    last = max((axis for _, axes, *_ in effects for axis in axes), default=0)
    return Extras(tuple(listed), tuple(notes), where, changed, last)


def _values(effect: Mapping[str, Any]) -> dict[str, float]:
    return {name: float(one["value"]) for name, one in effect["parameters"].items()}


def _deviations(effect: Mapping[str, Any]) -> dict[str, float]:
    """Standard deviations of the values that have one."""
    wide = {
        name: (float(one["ci95"][1]) - float(one["ci95"][0])) / (2 * NORMAL)
        for name, one in effect["parameters"].items()
        if one.get("ci95") and None not in one["ci95"]
    }
    return {name: value for name, value in wide.items() if math.isfinite(value) and value > 0}


def _reason(effect: Effect) -> str:
    """Why an effect is not fitted beside a base model, or nothing."""
    if effect.feedforward:
        return effect.feedforward
    if effect.acts_on not in ("torque", "drive") or effect.geared:
        return "it is no torque of the motion alone"
    return ""


def _on_axis(
    effect: Effect,
    axis: int,
    axes: int,
    values: Mapping[str, float],
    deviations: Mapping[str, float],
) -> list[Extra]:
    """All of it on an axis, from 1: it may be there twice with other shapes."""
    extras = []
    for number in range(1, effect.most + 1):
        more = f"#{number}" if number > 1 else ""

        def named(listed: Mapping[str, float], name: str, more: str = more) -> float | None:
            return listed.get(f"{name}[{axis}]{more}", listed.get(f"{name}{more}"))

        first = effect.gains[0].name
        there = f"{first}[{axis}]{more}" in values or (axes == 1 and f"{first}{more}" in values)
        own = {s.name: named(values, s.name) for s in effect.shapes}
        own |= {s.name: s.start for s in effect.shapes if s.optional and own[s.name] is None}
        shape = {name: value for name, value in own.items() if value is not None}
        if there and len(shape) == len(own):
            gains = tuple(named(values, gain.name) or 0.0 for gain in effect.gains)
            known = {s.name: named(deviations, s.name) for s in effect.shapes}
            sure = {name: value for name, value in known.items() if value is not None}
            extras.append(Extra(effect, axis - 1, shape, number, gains, sure))
    return extras

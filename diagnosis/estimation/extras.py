"""Effects that a diagnosis found, fitted beside a base model.

    tau = Y p + friction + sum gain column(shape)

The gains are estimated anew with all other parameters, the shapes stay as they were found. Dry and
viscous friction and an offset are in every identification already.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Known
from flexhex.diagnosis.estimation.changes import Change, changes_of
from flexhex.diagnosis.estimation.friction import PARAMETER
from flexhex.diagnosis.hypotheses.candidates import Bench
from flexhex.diagnosis.hypotheses.compiled import compiled
from flexhex.diagnosis.kinds import kinds_of
from flexhex.diagnosis.regression.calibrate import Calibrated
from flexhex.fmus.common.effects import Effect, library
from flexhex.fmus.common.errors import UsageError, unreadable

Array = NDArray[np.float64]
GROUP = "effect"


@dataclass(frozen=True)
class Extra:
    """An effect on an axis, from 0, with its shape; number: which of several on one axis."""

    effect: Effect
    axis: int
    shape: Mapping[str, float]
    number: int = 1

    def parameter(self, name: str) -> str:
        """A gain's or shape's name among all parameters: `cogging_harmonic.a[2]`."""
        more = f"_{self.number}" if self.number > 1 else ""
        return f"{self.effect.id}{more}.{name}[{self.axis + 1}]"


@dataclass(frozen=True)
class Extras:
    """What is fitted beside; notes: what is not, and why; where: what says so; changed: parameters
    of the base model and payloads."""

    listed: tuple[Extra, ...] = ()
    notes: tuple[str, ...] = ()
    where: str = ""
    changed: tuple[Change, ...] = ()

    def beside(self, friction: Sequence[Known]) -> list[Known]:
        """Parameters of friction without those that an effect has in its gains."""
        twice = {
            f"{PARAMETER[one.effect.extends]}[{one.axis + 1}]"
            for one in self.listed
            if one.effect.extends in PARAMETER
        }
        return [known for known in friction if known.name not in twice]

    def check(self, n: int) -> None:
        """UsageError where they are another machine's."""
        beyond = [one for one in self.listed if one.axis >= n]
        if beyond:
            raise UsageError(
                f"{self.where}: {beyond[0].effect.id} on axis {beyond[0].axis + 1}, the base"
                f" model has {n}: diagnose these logs"
            )

    def columns(self, model: Calibrated) -> list[Array]:
        """Smoothed columns (m, n, k) of all gains in each block."""
        n = model.base.n
        count = sum(len(one.effect.gains) for one in self.listed)
        columns = [np.zeros((len(block.at), n, count)) for block in model.blocks]
        if self.listed:
            bench = Bench(model, compiled(n, {one.effect.id: one.effect for one in self.listed}))
        place = 0
        for one in self.listed:
            width = len(one.effect.gains)
            for whole, own in zip(
                columns, bench.thin(one.effect.id, one.axis, one.shape), strict=True
            ):
                whole[:, one.axis, place : place + width] = own
            place += width
        return columns

    def parameters(self, model: Calibrated) -> list[Known]:
        """The gains, with weak priors: one standard deviation makes all of the axis' torque."""
        known, place, kinds = list[Known](), 0, kinds_of(model.base, model.base.n)
        columns = np.concatenate(self.columns(model)) if self.listed else None
        for one in self.listed:
            for gain in one.effect.gains:
                assert columns is not None
                size = float(np.sqrt((columns[:, one.axis, place] ** 2).mean()))
                most = float(model.torque_rms[one.axis]) / max(size, np.finfo(float).tiny)
                name, unit = one.parameter(gain.name), kinds[one.axis].unit(gain.unit)
                known.append(Known(name, unit, 0.0, most, GROUP, one.axis, bounded=gain.low >= 0.0))
                place += 1
        return known


def read_diagnosis(path: Path) -> Extras:
    """Effects and changes of a diagnosis that a file keeps (`flexhex diagnose`, `diagnosis.json`).
    UsageError for another file."""
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise UsageError(f"--diagnosis {unreadable(path, error)}") from None
    except ValueError:
        data = None
    return extras_of(data, f"--diagnosis {path}")


def extras_of(data: Any, where: str) -> Extras:
    """The same of a diagnosis as data; where: how it is called in an error."""
    try:
        effects = [
            (e["id"], list(e["axes"]), _values(e), list(e["rivals"])) for e in data["effects"]
        ]
        changed = changes_of(data.get("changed", ()))
    except (ValueError, KeyError, TypeError, AttributeError):
        text = "is no diagnosis: name the diagnosis.json that `flexhex diagnose` wrote"
        raise UsageError(f"{where}: {text}") from None
    if not effects and not changed:
        note = f"the diagnosis names nothing that is missing (verdict `{data.get('verdict')}`)"
        return Extras(notes=(f"{note}: nothing is fitted beside",), where=where)
    known, listed, notes = library(), list[Extra](), list[str]()
    for id, axes, values, rivals in effects:
        effect = known.get(id)
        reason = "no effect of the library" if effect is None else _reason(effect)
        if reason or effect is None:
            notes.append(f"{id} is not fitted: {reason}")
            continue
        if rivals:
            notes.append(f"{id} is indistinguishable from {', '.join(rivals)}: it is fitted")
        if id in PARAMETER:
            continue
        for axis in axes:
            there = _on_axis(effect, axis, len(axes), values)
            listed += there
            if not there:
                notes.append(f"{id} is not fitted on axis {axis}: it has no values there")
    return Extras(tuple(listed), tuple(notes), where, changed)


def _values(effect: Mapping[str, Any]) -> dict[str, float]:
    return {name: float(one["value"]) for name, one in effect["parameters"].items()}


def _reason(effect: Effect) -> str:
    """Why an effect is not fitted beside a base model, or nothing."""
    if effect.feedforward:
        return effect.feedforward
    if effect.acts_on not in ("torque", "drive") or effect.geared:
        return "it is no torque of the motion alone"
    return ""


def _on_axis(effect: Effect, axis: int, axes: int, values: Mapping[str, float]) -> list[Extra]:
    """All of it on an axis, from 1: it may be there twice with other shapes."""
    extras = []
    for number in range(1, effect.most + 1):
        more = f"#{number}" if number > 1 else ""
        own = {
            s.name: values.get(f"{s.name}[{axis}]{more}", values.get(f"{s.name}{more}"))
            for s in effect.shapes
        }
        gain = effect.gains[0].name
        there = f"{gain}[{axis}]{more}" in values or (axes == 1 and f"{gain}{more}" in values)
        if there and all(value is not None for value in own.values()):
            shape = {name: float(value) for name, value in own.items() if value is not None}
            extras.append(Extra(effect, axis - 1, shape, number))
    return extras

"""An entry of a machine file's `[[effects]]`: which effect, on which axes, how large.

    [[effects]]
    id = "coulomb_friction"
    axes = [3, 5]
    [effects.parameters]
    F_c = { value = [0.05, 0.04], unit = "N m", source = "diagnosed", ci95 = [0.04, 0.06] }
    s_0 = { value = 0.002, unit = "rad", source = "assumed" }

A gain has one value for all its axes or one for each, a shape has one. An effect of the user's own
has `id = "gas_spring.py:GasSpring"`, seen from the machine file, or the name that an installed
package offers.
"""

from __future__ import annotations

import difflib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from hashlib import sha256
from typing import Annotated, Any

from pydantic import ConfigDict, Field, ValidationInfo, model_validator

from flexhex.fmus.common.effects import Effect, Gain, Shape, library
from flexhex.fmus.common.effects.own import OwnEffect, own_effect
from flexhex.fmus.common.errors import FlexhexError
from flexhex.fmus.common.machine.quantity import quantity
from flexhex.fmus.common.machine.sections import Section
from flexhex.fmus.common.user_code import EFFECT_GROUP, offered, split

_KEYS = ("id", "axes", "parameters")


@dataclass(frozen=True)
class Elsewhere:
    """A file of another machine, whose values may stand alone and beyond the library's ranges, but
    for signs and shares; unit: of what the library has in a unit for an axis that turns. Context of
    validation."""

    unit: Callable[[str], str]


class EffectUse(Section):
    """One effect on some axes (from 1; none where it belongs to the whole machine).

    id: of the library, `FILE.py:NAME` of the user's own as seen from the machine file, or of a
    package. gains: a row for each gain, a value for each axis; shapes: a value for each shape; both
    in the order and units of the effect.
    """

    model_config = ConfigDict(arbitrary_types_allowed=True)

    id: str
    axes: tuple[Annotated[int, Field(ge=1, strict=True)], ...] = ()
    gains: tuple[tuple[float, ...], ...]
    shapes: tuple[float, ...]
    own: Annotated[OwnEffect | None, Field(repr=False, exclude=True)] = None
    made_of: Annotated[str, Field(exclude=True)] = ""
    """Of a user's own: hash of the expression that FMUs get, a part of what they are kept under."""

    @staticmethod
    def of(id: str, axes: Sequence[int] = (), **values: float | Sequence[float]) -> EffectUse:
        """An entry from plain numbers [library's units], checked like a file's."""
        effect = _known(id)
        units = {gain.name: gain.unit for gain in effect.gains}
        units |= {shape.name: shape.unit for shape in effect.shapes}
        tables = {
            name: {"value": _plain(value), "unit": units.get(name, ""), "source": "assumed"}
            for name, value in values.items()
        }
        entry = {"id": id, "parameters": tables} | ({"axes": list(axes)} if axes else {})
        return EffectUse.model_validate(entry)

    @property
    def effect(self) -> Effect:
        """The effect of the library, or the user's own."""
        return self.own or library()[self.id]

    @property
    def shape(self) -> dict[str, float]:
        """Values of the shapes by name."""
        names = (shape.name for shape in self.effect.shapes)
        return dict(zip(names, self.shapes, strict=True))

    @model_validator(mode="before")
    @classmethod
    def _read(cls, data: Any, info: ValidationInfo) -> Any:
        if not isinstance(data, dict) or not isinstance(data.get("parameters"), dict):
            raise ValueError("wants id, axes and a table [effects.parameters]")
        unknown = sorted(set(data) - set(_KEYS))
        if unknown:
            raise ValueError(f"{unknown[0]!r} is not a known key, allowed: {', '.join(_KEYS)}")
        if "id" not in data:
            raise ValueError('id: is missing: add id = "coulomb_friction" or another effect')
        effect, tables = _known(data["id"]), data["parameters"]
        axes = _axes(effect, data.get("axes"))
        names = [*(g.name for g in effect.gains), *(s.name for s in effect.shapes if not s.aside)]
        usual = {s.name: s.start for s in effect.shapes if s.optional or s.aside}
        for name in tables:
            if name not in names:
                raise ValueError(f"parameters.{name}: {effect.id} has only {_text(names)}")
        for name in names:
            if name not in tables and name not in usual:
                raise ValueError(f"parameters.{name}: is missing; {effect.id} has {_text(names)}")
        where: Elsewhere | None = info.context
        gains = [_gain(gain, tables[gain.name], max(1, len(axes)), where) for gain in effect.gains]
        shapes = [
            _shape(shape, tables[shape.name], where) if shape.name in tables else usual[shape.name]
            for shape in effect.shapes
        ]
        read = {"id": effect.id, "axes": axes, "gains": gains, "shapes": shapes}
        return read | (_own(effect, axes, shapes) if isinstance(effect, OwnEffect) else {})


def _known(id: Any) -> Effect:
    effects: Mapping[str, Effect] = library()
    if isinstance(id, str) and id in effects:
        return effects[id]
    packages = offered(EFFECT_GROUP)
    if isinstance(id, str) and (split(id) or id in packages):
        try:
            return own_effect(id, "id =")
        except FlexhexError as error:
            raise ValueError(str(error)) from error
    near = difflib.get_close_matches(str(id), [*effects, *packages], n=1)
    hint = f"did you mean {near[0]!r}?" if near else f"there are {_text([*effects, *packages])}"
    raise ValueError(f'there is no effect {id!r}, {hint}; one of your own is "FILE.py:NAME"')


def _own(effect: OwnEffect, axes: Sequence[Any], shapes: Sequence[float]) -> dict[str, Any]:
    """The user's effect and the hash of its expression. ValueError where it cannot be built."""
    strange = [axis for axis in axes if effect.on and axis not in effect.on]
    if strange:
        raise ValueError(f"axes: {strange[0]}, {effect.id} is for {_text(map(str, effect.on))}")
    names = [shape.name for shape in effect.shapes]
    try:
        made = effect.function(dict(zip(names, shapes, strict=True)))
    except FlexhexError as error:
        raise ValueError(str(error)) from error
    return {"own": effect, "made_of": sha256(made.serialize().encode()).hexdigest()[:16]}


def _axes(effect: Effect, axes: Any) -> list[int]:
    if effect.acts_on == "mechanism":
        if axes is not None:
            raise ValueError(f"axes: {effect.id} belongs to the whole machine, take axes out")
        return []
    if not isinstance(axes, list) or not axes:
        raise ValueError("axes: wants a list of axes such as [1, 3]")
    if len(set(map(str, axes))) < len(axes):
        raise ValueError(f"axes: {axes} names an axis twice")
    return axes


def _gain(gain: Gain, table: Any, n_axes: int, where: Elsewhere | None) -> tuple[float, ...]:
    many = isinstance(table.get("value") if isinstance(table, dict) else table, list)
    within = {"ge": gain.low, "le": gain.high}
    if where is not None and gain.unit != "1":
        within = {"ge": 0.0} if gain.low == 0 else {}
    values = _quantity(gain, within, table, where, *((n_axes,) if many else ()))
    return tuple(values) if many else (values,) * n_axes


def _shape(shape: Shape, table: Any, where: Elsewhere | None) -> float:
    within = {"ge": shape.low, "le": shape.high}
    if where is not None:
        within = {} if shape.low < 0 else {"gt": 0.0} if shape.low else {"ge": 0.0}
    value: float = _quantity(shape, within, table, where)
    if shape.whole and value not in shape.grid:
        allowed = _text([f"{v:g}" for v in shape.grid])
        raise ValueError(f"parameters.{shape.name}: {value:g}, allowed: {allowed}")
    return value


def _quantity(
    par: Gain | Shape,
    within: Mapping[str, float],
    table: Any,
    where: Elsewhere | None,
    *size: int,
) -> Any:
    unit = where.unit(par.unit) if where else par.unit
    read: Any = quantity(unit, *size, **within, bare=where is not None).func
    try:
        return read(table)
    except ValueError as error:
        raise ValueError(f"parameters.{par.name}: {error}") from None


def _plain(value: float | Sequence[float]) -> Any:
    return float(value) if isinstance(value, (int, float)) else [float(v) for v in value]


def _text(names: Iterable[str]) -> str:
    return ", ".join(names)

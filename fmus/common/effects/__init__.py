"""The library of effects: every module of this folder that defines EFFECT or EFFECTS."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Mapping
from functools import cache
from types import MappingProxyType

from flexhex.fmus.common.effects.effect import (
    Effect,
    Experiment,
    Expr,
    Gain,
    Shape,
    Shapes,
    Signals,
    State,
)
from flexhex.fmus.common.errors import MachineError

__all__ = ["Effect", "Experiment", "Expr", "Gain", "Shape", "Shapes", "Signals", "State", "library"]


@cache
def library() -> Mapping[str, Effect]:
    """All effects by id, module by module in alphabetical order.

    Raises MachineError for an id that exists twice and for what `check` refuses.
    """
    effects: dict[str, Effect] = {}
    for module in sorted(m.name for m in pkgutil.iter_modules(__path__)):
        loaded = importlib.import_module(f"{__name__}.{module}")
        listed = getattr(loaded, "EFFECTS", None) or [getattr(loaded, "EFFECT", None)]
        for effect in (e for e in listed if e is not None):
            check(effect, where=module)
            if effect.id in effects:
                raise MachineError(f"effects/{module}.py: the id {effect.id!r} exists twice")
            effects[effect.id] = effect
    for effect in effects.values():
        strangers = sorted(set(effect.confused_with) - set(effects))
        if strangers:
            raise MachineError(f"effect {effect.id}: confused_with has no effect {strangers[0]!r}")
    return MappingProxyType(effects)


def check(effect: Effect, where: str) -> None:
    """Raise MachineError when an effect lacks an attribute or contradicts itself."""
    what = f"effects/{where}.py: {getattr(effect, 'id', 'an effect without id')}"
    for name in ("id", "title", "acts_on", "gains", "excites", "experiment", "spec"):
        if not getattr(effect, name, None):
            raise MachineError(f"{what}: sets no {name}")
    names = [*(g.name for g in effect.gains), *(s.name for s in effect.shapes)]
    if len(set(names)) < len(names):
        raise MachineError(f"{what}: a parameter name exists twice: {', '.join(names)}")
    for gain in effect.gains:
        if not (gain.low <= 0 <= gain.high and 0 < gain.typical <= gain.high):
            raise MachineError(
                f"{what}: gain {gain.name}: wants low <= 0 <= high and 0 < typical <= high"
            )
    for shape in effect.shapes:
        if not all(shape.low <= v <= shape.high for v in (shape.start, *shape.grid)):
            raise MachineError(f"{what}: shape {shape.name}: start or grid beyond low..high")

"""The members of a user's effect, read; what is none of them is refused by a MachineError."""

from __future__ import annotations

import math
from collections.abc import Sequence
from difflib import get_close_matches
from typing import Any

from flexhex.fmus.common.effects import Gain, Shape
from flexhex.fmus.common.errors import MachineError

NEEDED, OPTIONAL = ("gains", "columns"), ("shapes", "on", "most")
TYPICAL = 0.01
"""Size of a gain, in its own unit, below which the estimator counts it as zero: that of most
torques of the library [N m]."""


def refuse_misspelt(model: object, name: str) -> None:
    """MachineError for a member that is missing or nearly called as one of ours."""
    there = [member for member in dir(model) if not member.startswith("_")]
    for member in there:
        close = get_close_matches(member, (*NEEDED, *OPTIONAL), 1, 0.8)
        if close and member not in (*NEEDED, *OPTIONAL) and close[0] not in there:
            raise MachineError(f"{name}: there is no member `{member}`: is it `{close[0]}`?")
    missing = [member for member in NEEDED if member not in there]
    if missing:
        raise MachineError(
            f"{name}: no `{missing[0]}`: an effect has `gains` and `columns`"
            " (`flexhex init effect.py` writes an example)"
        )


def _listed(value: Any, what: str, how: str) -> Sequence[Any]:
    plain = isinstance(value, Sequence) and not isinstance(value, str)
    if not plain or any(isinstance(v, str) or not isinstance(v, Sequence) for v in value):
        raise MachineError(f"{what} = {value!r}: write a list of {how}")
    return list(value)


def gains_of(value: Any, name: str) -> list[Gain]:
    """`gains`; name: how messages call the effect."""
    how = '(name, unit) or (name, unit, "positive")'
    gains = []
    for entry in _listed(value, f"{name}: gains", how):
        texts = all(isinstance(v, str) for v in entry)
        if not texts or len(entry) not in (2, 3) or entry[2:] not in ((), ("positive",), []):
            raise MachineError(f"{name}: gains: {entry!r}: write {how}")
        low = 0.0 if len(entry) == 3 else -math.inf
        if not entry[0].isidentifier():
            raise MachineError(f"{name}: gains: {entry[0]!r}: name it with letters, digits and _")
        gains.append(Gain(entry[0], entry[1], TYPICAL, low))
    if not gains:
        raise MachineError(f"{name}: gains is empty: list a parameter, {how}")
    return gains


def shapes_of(value: Any, name: str) -> list[Shape]:
    """`shapes`, taken as they stand."""
    how = '(name, unit, (values to try)), as in ("pitch", "m", (0.01, 0.02))'
    shapes = []
    for entry in _listed(value, f"{name}: shapes", how):
        try:
            own, unit, values = entry
            grid = tuple(sorted(float(v) for v in values))
            good = isinstance(own, str) and own.isidentifier() and isinstance(unit, str)
        except (TypeError, ValueError):
            good, grid = False, ()
        if not good or not grid or not all(map(math.isfinite, grid)):
            raise MachineError(f"{name}: shapes: {entry!r}: write {how}")
        shapes.append(Shape(own, unit, grid[0], grid[-1], grid[0], grid, as_is=True))
    return shapes


def axes_of(value: Any, name: str) -> list[int]:
    """`on`: axes from 1."""
    listed = [value] if isinstance(value, int) else list(value)
    if not all(isinstance(v, int) and v >= 1 for v in listed):
        raise MachineError(f"{name}: on = {value!r}: write axes from 1 on, (1, 3)")
    return listed

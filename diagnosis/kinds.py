"""What an axis moves along: an angle against a torque, or a length against a force.

The library and the base models write their quantities for axes that turn. Units, words and names
for an axis that slides are derived from those, here and nowhere else.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache

from flexhex.fmus.common.errors import LogError


@dataclass(frozen=True)
class Kind:
    """How the quantities of an axis are called.

    position, effort: words; inertia: symbol; turns: whether it turns, so that angles have a size of
    their own, which lengths have not; pieces: what stands in a unit for an axis that turns, and
    what stands there for this one.
    """

    name: str
    position: str
    effort: str
    inertia: str
    turns: bool
    pieces: tuple[tuple[str, str], ...] = ()

    def unit(self, rotary: str) -> str:
        """The unit of what has the unit `rotary` on an axis that turns: `kg m2` is `kg` here."""
        for old, new in self.pieces:
            rotary = rotary.replace(old, new)
        return rotary


ROTARY = Kind("rotary", "angle", "torque", "J", True)
LINEAR = Kind(
    "linear",
    "position",
    "force",
    "m",
    False,
    (("N2 m2", "N2"), ("N m", "N"), ("kg m2", "kg"), ("rad", "m")),
)
KINDS = (ROTARY, LINEAR)
IN_VOLTS = {
    ROTARY: Kind(
        "rotary in volts",
        "angle",
        "voltage",
        "J",
        True,
        (("N2 m2", "V2"), ("N m", "V"), ("kg m2", "V s2/rad")),
    ),
    LINEAR: Kind(
        "linear in volts",
        "position",
        "voltage",
        "m",
        False,
        (("N2 m2", "V2"), ("N m", "V"), ("kg m2", "V s2/m"), ("rad", "m")),
    ),
}
"""Axes whose torque or force is known as a voltage alone, of an unknown motor."""
Kinds = tuple[Kind, ...]


def kinds_of(owner: object, n: int) -> Kinds:
    """Kinds of the n axes of a log or a base model: they turn unless it says otherwise."""
    kinds: Kinds = getattr(owner, "kinds", ()) or (ROTARY,) * n
    return kinds


def axes_named(axes: Iterable[int]) -> str:
    """`axis 3`, `axes 1, 2 and 5`; axes from 0."""
    *others, last = (str(axis + 1) for axis in axes)
    return f"axes {', '.join(others)} and {last}" if others else f"axis {last}"


def units_of(owner: object, n: int, unit: str) -> tuple[str, ...]:
    """The unit of each axis of what has this one on axes that turn."""
    return tuple(kind.unit(unit) for kind in kinds_of(owner, n))


@cache
def powers(unit: str) -> tuple[int, int]:
    """Powers of torque and of angle in a unit for axes that turn: 1 and -2 in `N m/rad2`."""
    above, _, below = unit.partition("/")

    def power(symbol: str) -> int:
        pattern = rf"\b{symbol}(\d*)\b"
        counts = [[int(p or 1) for p in re.findall(pattern, part)] for part in (above, below)]
        return sum(counts[0]) - sum(counts[1])

    # kg m2 is N m s2/rad
    return power("N") + power("kg"), power("rad") - power("kg")


UNITS = "correct the units of theta and tau_meas, or diagnose its axes by themselves (--base axis)"
CONSTANTS = (
    "give the data of the motor (--motor 'R=1.2 K_t=0.05') or the constant of a current amplifier"
    " (--torque-constant), or diagnose its axes by themselves (--base axis) with all logs in V"
)
"""What mends a log whose axes are of another kind."""


def refuse_others(name: str, kinds: Sequence[Kind], wanted: Sequence[Kind], of: str) -> None:
    """LogError when an axis of the log `name` is not of the kind that `of` has there."""
    for k, (own, other) in enumerate(zip(kinds, wanted, strict=False), start=1):
        if own is not other:
            raise LogError(
                f"{name}: axis {k} is {own.name} ({own.position} in {own.unit('rad')},"
                f" {own.effort} in {own.unit('N m')}), that of {of} is {other.name}: "
                + (CONSTANTS if "V" in (own.unit("N m"), other.unit("N m")) else UNITS)
            )


def absolute(kind: Kind) -> Kind:
    """The kind of the same axis in N m or N."""
    return next((plain for plain, other in IN_VOLTS.items() if other is kind), kind)


def with_unit(value: str, unit: str) -> str:
    """A value with its unit; unit 1 is left out, as it reads as a second number."""
    return value if unit in ("1", "") else f"{value} {unit}"

"""Units of FMU variables: exponents of SI base units, and display units."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field

from flexhex.fmus.common.errors import InterfaceError
from flexhex.fmus.common.interface import Variable


@dataclass(frozen=True)
class Unit:
    """Exponents of kg, m, s, A, rad; display units as (name, factor from the SI unit).

    usual: the display unit that people read most values in; nominal: an ordinary size of such a
    signal on machines of this kind [unit], for importers that scale by it.
    """

    exponents: dict[str, int] = field(default_factory=dict)
    display: tuple[tuple[str, float], ...] = ()
    usual: str = ""
    nominal: float | None = None


_DEG = 180 / math.pi
UNITS: dict[str, Unit] = {
    "1": Unit(),
    "s": Unit({"s": 1}, (("ms", 1e3),)),
    "Hz": Unit({"s": -1}),
    "1/s": Unit({"s": -1}),
    "1/s2": Unit({"s": -2}),
    "rad": Unit({"rad": 1}, (("deg", _DEG), ("urad", 1e6)), "deg", 0.1),
    "1/rad": Unit({"rad": -1}),
    "rad/s": Unit({"rad": 1, "s": -1}, (("deg/s", _DEG),), "deg/s", 1.0),
    "rad/s2": Unit({"rad": 1, "s": -2}, (("deg/s2", _DEG),), "deg/s2", 10.0),
    "m": Unit({"m": 1}, (("mm", 1e3), ("um", 1e6)), "mm", 0.1),
    "m/s": Unit({"m": 1, "s": -1}),
    "m/s2": Unit({"m": 1, "s": -2}),
    "kg": Unit({"kg": 1}),
    "kg m": Unit({"kg": 1, "m": 1}),
    "kg m2": Unit({"kg": 1, "m": 2}),
    "N m": Unit({"kg": 1, "m": 2, "s": -2}, (("mN m", 1e3),), "", 1.0),
    "N m/rad": Unit({"kg": 1, "m": 2, "s": -2, "rad": -1}),
    "N m s/rad": Unit({"kg": 1, "m": 2, "s": -1, "rad": -1}),
    "N2 m2": Unit({"kg": 2, "m": 4, "s": -4}),
    "A": Unit({"A": 1}),
    "N m/A": Unit({"kg": 1, "m": 2, "s": -2, "A": -1}),
}


def display_unit(variable: Variable, name: str) -> str:
    """What values of this unit are shown in: the variable's wish, else the usual; empty: none.

    InterfaceError for a wish that is no display unit of the unit.
    """
    known = unit(name, variable.name)
    if not variable.display:
        return known.usual
    if variable.display not in [shown for shown, _ in known.display]:
        raise InterfaceError(
            f"{variable.name}: cannot be shown in {variable.display!r}, its unit {name} has"
            f" {', '.join(shown for shown, _ in known.display) or 'no display units'}"
        )
    return variable.display


_SYMBOLS = {symbol: UNITS[symbol].exponents for symbol in ("kg", "m", "s", "A", "rad", "Hz")} | {
    "N": {"kg": 1, "m": 1, "s": -2},
    "V": {"kg": 1, "m": 2, "s": -3, "A": -1},
}
_FACTOR = re.compile(r"([A-Za-z]+)([1-9]?)")


def unit(name: str, variable: str) -> Unit:
    """The unit called `name`, of the table above or a product such as `N m s2/rad2`.

    InterfaceError that names the variable when it is neither.
    """
    if name in UNITS:
        return UNITS[name]
    over, *under = name.split("/")
    exponents: dict[str, int] = {}
    for side, text in ((1, "" if over == "1" else over), (-1, " ".join(under))):
        for word in text.split():
            factor = _FACTOR.fullmatch(word)
            if len(under) > 1 or factor is None or factor[1] not in _SYMBOLS:
                raise InterfaceError(
                    f"{variable}: unknown unit {name!r}, known: {', '.join(UNITS)} and products"
                    f" of {', '.join(_SYMBOLS)} such as 'N m s2/rad2'"
                )
            for base, power in _SYMBOLS[factor[1]].items():
                signed = side * power * int(factor[2] or 1)
                exponents[base] = exponents.get(base, 0) + signed
    return Unit({base: power for base, power in exponents.items() if power})

"""Data of the motors of logs in volts, as a user writes them: `R=1.2 K_t=0.05 L=0.5 mH`."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from math import inf, isfinite, pi

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.kinds import LINEAR, ROTARY, Kind, Kinds
from flexhex.fmus.common.errors import UsageError

Array = NDArray[np.float64]
Given = str | Mapping[str, object]
_RPM = 60 / (2 * pi)
UNITS: Mapping[str, Mapping[str, tuple[float, Kind | None]]] = {
    "R": {"ohm": (1.0, None), "Ohm": (1.0, None), "Ω": (1.0, None), "mohm": (1e-3, None)},
    "K_t": {
        "Nm/A": (1.0, ROTARY),
        "mNm/A": (1e-3, ROTARY),
        "N/A": (1.0, LINEAR),
        "mN/A": (1e-3, LINEAR),
    },
    "K_e": {
        "Vs/rad": (1.0, ROTARY),
        "mVs/rad": (1e-3, ROTARY),
        "V/rpm": (_RPM, ROTARY),
        "mV/rpm": (1e-3 * _RPM, ROTARY),
        "V/krpm": (1e-3 * _RPM, ROTARY),
        "Vs/m": (1.0, LINEAR),
    },
    "L": {"H": (1.0, None), "mH": (1e-3, None), "uH": (1e-6, None)},
    "gear": {"rad/m": (1.0, LINEAR), "rad/mm": (1e3, LINEAR), "rad/rad": (1.0, ROTARY)},
    "gain": {"V/V": (1.0, None)},
}
"""Units of each entry: what a number in one is multiplied by to be SI, and of which motors or axes
it is, where it says so."""
NEEDED = ("R", "K_t")
USUAL = {"L": 0.0, "gear": 1.0, "gain": 1.0}
"""Entries that may be left out, as K_e, which then is K_t."""
LEAST = {"R": "above zero", "K_t": "above zero", "K_e": "above zero", "L": "not below zero"}
"""What each number must be; the others only other than zero."""
UNLIKE, SLOW = 2.0, 0.5
"""Ratio of K_e and K_t, one number in SI units for a motor with brushes, beyond which a unit may be
wrong: K_t per ampere RMS is sqrt(2) of that per ampere, sqrt(3/2) by phases. L/R [s] that no motor
has."""
EXAMPLE = "'R=1.2 K_t=0.05'"


@dataclass(frozen=True)
class Motor:
    """Motors of the axes, each entry one number for all axes or one for each, in SI units.

    R [ohm]; K_t [N m/A] or [N/A]; K_e [V s/rad] or [V s/m]; L [H]; gear: motion of the motor over
    that of the axis; gain: voltage of the motor over the logged one. kinds: of motors and gears
    where their units say it.
    """

    R: tuple[float, ...]
    K_t: tuple[float, ...]
    K_e: tuple[float, ...]
    L: tuple[float, ...]
    gear: tuple[float, ...]
    gain: tuple[float, ...]
    kinds: Mapping[str, Kind]
    geared: bool

    def each(self, name: str, n: int) -> Array:
        """An entry of all axes (n,)."""
        return np.broadcast_to(np.asarray(getattr(self, name), dtype=np.float64), (n,))

    def trouble(self, kinds: Kinds) -> str:
        """Why these are no motors of such axes, or nothing."""
        for name in UNITS:
            if len(values := getattr(self, name)) not in (1, len(kinds)):
                axes = f"{len(kinds)} {'axis' if len(kinds) == 1 else 'axes'}"
                return f"{name} has {len(values)} numbers for {axes}: one for all, or one for each"
        motors = {self.kinds[name] for name in ("K_t", "K_e") if name in self.kinds}
        if len(motors) > 1:
            return "K_t and K_e have units of different motors: N m/A and V s/rad, or N/A and V s/m"
        for k, kind in enumerate(kinds, start=1):
            if kind is ROTARY and LINEAR in motors:
                return f"axis {k} turns: its K_t is in N m/A"
            if kind is LINEAR and ROTARY in motors and not self.geared:
                return (
                    f"axis {k} is linear and K_t that of a motor that turns: give gear=, the"
                    " motor's angle over the way of the axis [rad/m]"
                )
            if self.kinds.get("gear", kind) is not kind:
                return f"gear is that of a {self.kinds['gear'].name} axis, axis {k} is {kind.name}"
        slow = float((self.each("L", len(kinds)) / self.each("R", len(kinds))).max())
        return f"L/R is {slow:.2g} s, as no motor has it: L=3.6 mH has its unit" * (slow > SLOW)

    @property
    def doubt(self) -> str:
        """What looks like a wrong unit, or nothing."""
        n = max(len(self.K_t), len(self.K_e))
        ratio = self.each("K_e", n) / self.each("K_t", n)
        far = bool((np.abs(np.log(ratio)) > np.log(UNLIKE)).any())
        return "K_e and K_t, one number in SI units for most motors, are far apart" if far else ""

    @property
    def text(self) -> str:
        """`R=1.2 K_t=0.05 K_e=0.05`, in SI units."""
        shown = [n for n in UNITS if getattr(self, n) != (USUAL.get(n),)]
        return " ".join(f"{n}={','.join(f'{v:.6g}' for v in getattr(self, n))}" for n in shown)


def motor_of(given: Given) -> Motor:
    """Data of motors from `R=1.2 K_t=0.05`, or from numbers by name, {"R": 1.2, "K_t": [1, 2]}.

    ValueError with what is wrong and how to mend it; the caller says where.
    """
    entries = dict(_split(given) if isinstance(given, str) else given)
    for name in entries:
        if name not in UNITS:
            near = get_close_matches(str(name), UNITS, 1)
            hint = f"did you mean {near[0]}?" if near else f"there are {', '.join(UNITS)}"
            raise ValueError(f"no entry {name!r}: {hint}")
    if missing := [name for name in NEEDED if name not in entries]:
        raise ValueError(f"{' and '.join(missing)} missing: write for instance {EXAMPLE}")
    kinds, values = dict[str, Kind](), dict[str, tuple[float, ...]]()
    for name, entry in entries.items():
        values[name], kind = _entry(name, entry)
        kinds |= {name: kind} if kind is not None else {}
    values = {"K_e": values["K_t"], **{n: (v,) for n, v in USUAL.items()}, **values}
    return Motor(**values, kinds=kinds, geared="gear" in entries)


def motor_option(constant: object, given: Given | None) -> Motor | None:
    """Data of motors as an option gives them, beside that of a torque constant. UsageError for
    wrong ones, and for both."""
    if given is None:
        return None
    if constant is not None:
        raise UsageError(
            "--motor: not beside --torque-constant: the data of a motor are for its voltage, the"
            " constant is for its current"
        )
    try:
        return motor_of(given)
    except ValueError as error:
        raise UsageError(f"--motor: {error}") from None


def _split(text: str) -> list[tuple[str, str]]:
    found = re.split(r"(?:^|[\s;,]+)([A-Za-z]\w*)\s*=", text)
    if found[0].strip() or len(found) < 3:
        raise ValueError(f"{text!r}: write for instance {EXAMPLE}")
    names = found[1::2]
    if twice := [name for name in names if names.count(name) > 1]:
        raise ValueError(f"{twice[0]} stands there twice: one for each axis is {twice[0]}=1.2,1.3")
    return list(zip(names, found[2::2], strict=True))


def _entry(name: str, entry: object) -> tuple[tuple[float, ...], Kind | None]:
    """Numbers in SI units, and of which kind the unit is."""
    scale, kind, listed = 1.0, None, entry
    if isinstance(entry, str):
        number = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?|[-+]?(?:nan|inf)"
        match = re.fullmatch(rf"\s*((?:{number})(?:\s*,\s*(?:{number}))*)\s*(.*?)\s*", entry, re.I)
        if match is None:
            raise ValueError(f"{name}={entry.strip()}: wanted a number, or one for each axis: 1,2")
        listed = [float(word) for word in match[1].split(",")]
        unit = re.sub(r"[\s*.·]", "", match[2]).replace("µ", "u").replace("μ", "u")
        if unit and unit not in UNITS[name]:
            known = ", ".join(UNITS[name])
            raise ValueError(f"{name} is in {match[2]!r}: units known here are {known}")
        scale, kind = UNITS[name][unit] if unit else (scale, kind)
    each = listed if isinstance(listed, Iterable) and not isinstance(listed, str) else [listed]
    values = [_number(name, value) for value in each]
    if not values:
        raise ValueError(f"{name} has no number")
    return tuple(scale * value for value in values), kind


def _number(name: str, value: object) -> float:
    wanted = LEAST.get(name, "other than zero")
    least = {"above zero": (0.0, False), "not below zero": (0.0, True)}.get(wanted, (-inf, False))
    if isinstance(value, bool) or not isinstance(value, int | float | np.number):
        raise ValueError(f"{name} is {value!r}: wanted a number")
    plain = float(value)
    sound = plain > least[0] or (least[1] and plain == least[0])
    if not (isfinite(plain) and sound and (plain or least[1])):
        raise ValueError(f"{name} is {plain:g}: it must be {wanted} and finite")
    return plain

"""Units of logs: converted where only one meaning is possible, refused otherwise."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence

from flexhex.diagnosis.kinds import LINEAR, ROTARY, Kind
from flexhex.fmus.common.errors import LogError

TURN = 2 * math.pi
TIME = {"s": 1.0, "sec": 1.0, "seconds": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
ANGLE = {
    "rad": 1.0,
    "mrad": 1e-3,
    "urad": 1e-6,
    "deg": TURN / 360,
    "degree": TURN / 360,
    "degrees": TURN / 360,
    "°": TURN / 360,
    "rev": TURN,
    "turn": TURN,
}
RATE = {
    "rad/s": 1.0,
    "mrad/s": 1e-3,
    "deg/s": TURN / 360,
    "°/s": TURN / 360,
    "rpm": TURN / 60,
    "1/min": TURN / 60,
    "rev/min": TURN / 60,
    "rev/s": TURN,
}
LENGTH = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "nm": 1e-9}
SPEED = {
    "m/s": 1.0,
    "mm/s": 1e-3,
    "um/s": 1e-6,
    "nm/s": 1e-9,
    "m/min": 1 / 60,
    "mm/min": 1e-3 / 60,
}
ACCELERATION = {"rad/s2": 1.0, "mrad/s2": 1e-3, "deg/s2": TURN / 360, "rev/s2": TURN}
FASTER = {"m/s2": 1.0, "mm/s2": 1e-3, "um/s2": 1e-6, "g": 9.80665}
TORQUE = {"N m": 1.0, "Nm": 1.0, "mN m": 1e-3, "mNm": 1e-3, "kN m": 1e3, "kNm": 1e3}
FORCE = {"N": 1.0, "kN": 1e3, "mN": 1e-3, "uN": 1e-6}
CURRENT = {"A": 1.0, "mA": 1e-3, "Arms": 1.0, "A rms": 1.0}
VOLTAGE = {"V": 1.0, "mV": 1e-3}
MOVING: Mapping[str, Mapping[Kind, Mapping[str, float]]] = {
    "theta": {ROTARY: ANGLE, LINEAR: LENGTH},
    "r": {ROTARY: ANGLE, LINEAR: LENGTH},
    "thetad": {ROTARY: RATE, LINEAR: SPEED},
    "thetadd": {ROTARY: ACCELERATION, LINEAR: FASTER},
    "tau_meas": {ROTARY: TORQUE, LINEAR: FORCE},
    "tau": {ROTARY: TORQUE, LINEAR: FORCE},
    "tau_ff": {ROTARY: TORQUE, LINEAR: FORCE},
}
"""Channels whose unit says what an axis moves along."""
KNOWN: Mapping[str, Mapping[str, float]] = {
    "time": TIME,
    **{name: {**of[ROTARY], **of[LINEAR]} for name, of in MOVING.items()},
    "current": {**CURRENT, **VOLTAGE},
    "voltage": VOLTAGE,
    "payload": {"kg": 1.0, "g": 1e-3},
    "temperature": {"degC": 1.0, "°C": 1.0, "C": 1.0, "celsius": 1.0},
}
SI = {"time": "s", "theta": "rad", "r": "rad", "thetad": "rad/s", "thetadd": "rad/s2"}
SI |= {"tau_meas": "N m", "tau": "N m", "tau_ff": "N m", "current": "A", "voltage": "V"}
SI |= {"payload": "kg", "temperature": "degC"}
WHY = {
    "nm": "nanometres, or N m?",
    "mnm": "mN m, or MN m?",
    "grad": "degrees (German) or gon?",
    "counts": "counts need their size: of 65536 in a turn each is rev/65536",
    "count": "counts need their size: of 65536 in a turn each is rev/65536",
    "inc": "increments need their size: of 65536 in a turn each is rev/65536",
    "%": "percent of what?",
    "1": "a number without unit",
    "-": "a number without unit",
}
ANY_CASE = {"rad", "deg", "rev", "rpm", "rad/s", "deg/s", "sec", "seconds", "degrees"}
CONSTANTS = {
    "Nm/A": (1.0, ROTARY),
    "mNm/A": (1e-3, ROTARY),
    "N/A": (1.0, LINEAR),
    "mN/A": (1e-3, LINEAR),
    "Nm/V": (1.0, ROTARY),
    "mNm/V": (1e-3, ROTARY),
    "N/V": (1.0, LINEAR),
    "mN/V": (1e-3, LINEAR),
}
TORQUES = ("tau_meas", "tau", "tau_ff")


def factor(where: str, channel: str, unit: str, axis: int = 1) -> float:
    """What a value in `unit` is multiplied by to be SI. LogError when that is not certain."""
    value = size_of(channel, unit)
    if value is not None:
        return value
    wanted = " or ".join(repr(kind.unit(SI[channel])) for kind in MOVING.get(channel, (ROTARY,)))
    named = channel if channel in ("time", "payload", "temperature") else f"{channel}[{axis}]"
    if not unit.strip():
        raise LogError(
            f"{where}: {channel} has no unit, wanted {wanted}: give it in the file"
            " (a row of units, an attribute `unit`) or with"
            f" --unit {channel}={SI[channel].replace(' ', '')}"
        )
    reason = WHY.get(unit.strip().lower(), "not a unit that is known here")
    raise LogError(
        f"{where}: {named} is in {unit!r}, wanted {wanted} ({reason}): convert it, or say what"
        f" it is with --unit {channel}=UNIT ({', '.join(KNOWN[channel])})"
    )


def kind_of(channel: str, unit: str) -> Kind | None:
    """Kind of an axis whose channel has this unit; None where it says nothing."""
    of_kind = MOVING.get(channel, {})
    return next((kind for kind, of in of_kind.items() if _look_up(of, unit) is not None), None)


def each_unit(where: str, channel: str, text: str, count: int) -> tuple[str, ...]:
    """Units of all axes of a channel: one for all, or one for each with commas between them."""
    listed = tuple(part.strip() for part in text.split(","))
    if len(listed) == 1:
        return listed * count
    if len(listed) != count:
        raise LogError(
            f"{where}: {channel} has {len(listed)} units ({text}) for"
            f" {count} {'axis' if count == 1 else 'axes'}: give one for all, or one for each"
        )
    return listed


def size_of(channel: str, unit: str) -> float | None:
    """What a value in `unit` is multiplied by to be SI; None where that is not certain."""
    return _look_up(KNOWN[channel], unit)


def is_current(channel: str, unit: str) -> bool:
    """Whether a torque channel is given as what the drive does: in amperes or volts."""
    return channel in TORQUES and _look_up(KNOWN["current"], unit) is not None


def is_voltage(unit: str) -> bool:
    """Whether a unit is one of volts."""
    return _look_up(VOLTAGE, unit) is not None


def plain_unit(unit: str) -> str:
    """A unit with `u` for micro."""
    return unit.strip().replace("\u00b5", "u").replace("\u03bc", "u")


def _look_up(known: Mapping[str, float], unit: str) -> float | None:
    plain = re.sub(r"(?<=/s)(\^2|\u00b2)$", "2", plain_unit(unit))
    small = plain.lower()
    for candidate in (plain, small if small in ANY_CASE else plain):
        if candidate in known:
            return known[candidate]
    # N*m, N.m, N·m, N-m and a narrow space all mean N m
    spaced = re.sub(r"(?<=N)[\s*.·⋅\-\u202f\u00a0]+(?=m$)", " ", plain)
    if spaced in known:
        return known[spaced]
    # rev/65536: an encoder's count
    part = re.fullmatch(r"(.+?)\s*/\s*([1-9]\d*(?:\.\d+)?)", plain)
    whole = known.get(part[1]) if part else None
    return None if part is None or whole is None else whole / float(part[2])


def torque_constant(where: str, text: str) -> tuple[tuple[float, ...], tuple[Kind, ...]]:
    """`3.0 N m/A`, `60 N/A`, or a number for each axis, [N m/A] or [N/A], and for which kinds of
    axis each is. A unit also stands for the numbers before it. LogError when it cannot be read."""
    values, kinds, unit = list[float](), list[Kind](), ""
    for piece in reversed(re.split(r"[,;]", text)):
        match = re.match(r"^\s*((?:[-+.\deE]+\s*)+)([A-Za-z].*)?$", piece)
        unit = re.sub(r"[\s*.·]", "", (match and match[2]) or "") or unit
        scale, kind = CONSTANTS.get(unit, (math.nan, ROTARY))
        for number in reversed(match[1].split() if match else ["nan"]):
            values, kinds = [scale * _number(number), *values], [kind, *kinds]
    if not all(math.isfinite(v) and v != 0 for v in values):
        raise LogError(
            f"{where}: torque_constant is {text!r}, wanted for instance '3.0 N m/A' or '60 N/A'"
        )
    return tuple(values), tuple(kinds)


def constants_shown(values: Sequence[float], units: Sequence[str]) -> str:
    """`3, 60 N m/A`, or each with its unit where axes have several; one value may be for all."""
    shown = [f"{value:.6g}" for value in values]
    if len(set(units)) == 1:
        return f"{', '.join(shown)} {units[0]}"
    shown = shown * len(units) if len(shown) == 1 else shown
    return ", ".join(f"{value} {unit}" for value, unit in zip(shown, units, strict=True))


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan

"""Units of logs: converted where only one meaning is possible, refused otherwise."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping

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
TORQUE = {"N m": 1.0, "Nm": 1.0, "mN m": 1e-3, "mNm": 1e-3, "kN m": 1e3, "kNm": 1e3}
CURRENT = {"A": 1.0, "mA": 1e-3}
KNOWN: Mapping[str, Mapping[str, float]] = {
    "time": TIME,
    "theta": ANGLE,
    "r": ANGLE,
    "thetad": RATE,
    "tau_meas": TORQUE,
    "tau": TORQUE,
    "tau_ff": TORQUE,
    "current": CURRENT,
    "payload": {"kg": 1.0, "g": 1e-3},
    "temperature": {"degC": 1.0, "°C": 1.0, "C": 1.0, "celsius": 1.0},
}
SI = {"time": "s", "theta": "rad", "r": "rad", "thetad": "rad/s", "payload": "kg"}
SI |= {"tau_meas": "N m", "tau": "N m", "tau_ff": "N m", "current": "A", "temperature": "degC"}
WHY = {
    "nm": "nanometres, or N m?",
    "mnm": "mN m, or MN m?",
    "grad": "degrees (German) or gon?",
    "m": "metres or minutes?",
    "counts": "counts need their size",
    "count": "counts need their size",
    "inc": "increments need their size",
    "%": "percent of what?",
    "1": "a number without unit",
    "-": "a number without unit",
}
ANY_CASE = {"rad", "deg", "rev", "rpm", "rad/s", "deg/s", "sec", "seconds", "degrees"}
LINEAR = {"m", "mm", "um", "cm", "m/s", "mm/s"}
"""Units of axes that move along a line."""
TORQUES = ("tau_meas", "tau", "tau_ff")


def factor(where: str, channel: str, unit: str) -> float:
    """What a value in `unit` is multiplied by to be SI. LogError when that is not certain."""
    found = _look_up(KNOWN[channel], unit)
    if found is not None:
        return found
    wanted = SI[channel]
    if not unit.strip():
        raise LogError(
            f"{where}: {channel} has no unit, wanted {wanted!r}: give it in the file"
            " (a row of units, an attribute `unit`) or with"
            f" --unit {channel}={wanted.replace(' ', '')}"
        )
    if (channel in ("theta", "thetad", "r") and plain_unit(unit) in LINEAR) or (
        channel in TORQUES and plain_unit(unit) in ("N", "kN")
    ):
        raise LogError(
            f"{where}: {channel}[1] is in {unit!r}, wanted {wanted!r}: only rotary axes are"
            f" supported so far, no linear ones; if the unit is wrong, give it: --unit"
            f" {channel}={wanted.replace(' ', '')}"
        )
    reason = WHY.get(unit.strip().lower(), "not a unit that is known here")
    named = f"{channel}[1]" if channel not in ("time", "payload", "temperature") else channel
    raise LogError(
        f"{where}: {named} is in {unit!r}, wanted {wanted!r} ({reason}): convert it, or say what"
        f" it is with --unit {channel}=UNIT ({', '.join(KNOWN[channel])})"
    )


def is_current(channel: str, unit: str) -> bool:
    """Whether a torque channel is given in amperes."""
    return channel in TORQUES and _look_up(CURRENT, unit) is not None


def plain_unit(unit: str) -> str:
    """A unit with `u` for micro."""
    return unit.strip().replace("\u00b5", "u").replace("\u03bc", "u")


def _look_up(known: Mapping[str, float], unit: str) -> float | None:
    plain = plain_unit(unit)
    small = plain.lower()
    for candidate in (plain, small if small in ANY_CASE else plain):
        if candidate in known:
            return known[candidate]
    # N*m, N.m, N·m, N-m and a narrow space all mean N m
    spaced = re.sub(r"(?<=N)[\s*.·⋅\-\u202f\u00a0]+(?=m$)", " ", plain)
    return known.get(spaced)


def torque_constant(where: str, text: str) -> tuple[float, ...]:
    """`3.0 N m/A`, or a number for each axis, [N m/A]. LogError when it cannot be read."""
    found = re.match(r"^\s*((?:[-+.\deE]+[\s,;]*)+)\s*(.*?)\s*$", text)
    unit = re.sub(r"[\s*.·]", "", found[2]) if found else ""
    scale = {"Nm/A": 1.0, "mNm/A": 1e-3}.get(unit)
    try:
        values = (
            tuple(float(word) for word in re.split(r"[\s,;]+", found[1].strip())) if found else ()
        )
    except ValueError:
        values = ()
    good = scale is not None and values and all(math.isfinite(v) and v > 0 for v in values)
    if not good or scale is None:
        raise LogError(f"{where}: torque_constant is {text!r}, wanted for instance '3.0 N m/A'")
    return tuple(scale * v for v in values)

"""Options that say how to read logs; shared by `diagnose` and `identify`."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Annotated

import typer

from flexhex.fmus.common.errors import UsageError

if TYPE_CHECKING:
    from flexhex.diagnosis.logs import Options

TorqueConstant = Annotated[
    str | None,
    typer.Option(
        metavar="N m/A, N/A",
        help="torque constant of logs in A or V: one number, or one for each axis: 3.0,3.1",
    ),
]
Motor = Annotated[
    str | None,
    typer.Option(
        metavar="'R=OHM K_t=...'",
        help="motor of logs in V: R [ohm], K_t [N m/A, N/A], also K_e (default: K_t), L [H] (0),"
        " gear (1), gain of the amplifier (1); of several axes one number, or one for each: R=1,2",
    ),
]
Unit = Annotated[
    list[str] | None,
    typer.Option(
        metavar="CHANNEL=UNIT",
        help="unit of a channel whose file does not state it: theta=deg, or by axis: theta=deg,mm;"
        " where the file is wrong: 'theta=deg not rad'",
    ),
]
Rename = Annotated[
    list[str] | None,
    typer.Option(
        metavar="NAME=CHANNEL", help="map a column name to a channel: 'Position [deg]=theta[1]'"
    ),
]


def log_options(
    constant: str | None, units: list[str], names: list[str], motor: str | None = None
) -> Options:
    """How to read logs. UsageError for a wrong option."""
    from flexhex.diagnosis.logs import Options
    from flexhex.diagnosis.logs.motor import motor_option

    constants: float | tuple[float, ...] | None = None
    if constant is not None:
        try:
            constants = tuple(float(word) for word in constant.split(","))
        except ValueError:
            text = f"--torque-constant {constant}: write a number, or one for each axis: 3.0,3.1"
            raise UsageError(text) from None
        if not all(0 < abs(value) < float("inf") for value in constants):
            raise UsageError(f"--torque-constant {constant}: must be a number other than zero")
        constants = constants[0] if len(constants) == 1 else constants
    return Options(constants, _units(units), _names(names), motor=motor_option(constants, motor))


def _units(words: list[str]) -> dict[str, str]:
    from flexhex.diagnosis.logs.units import KNOWN

    units = _pairs("--unit", words)
    for name, unit in units.items():
        if name not in KNOWN:
            plain = re.sub(r"\W*\d+\W*$", "", name)
            remedy = f"write {plain}={unit}, for all its axes" if plain in KNOWN else ""
            raise UsageError(
                f"--unit {name}={unit}: no channel of that name;"
                f" {remedy or 'there are ' + ', '.join(KNOWN)}"
            )
    return units


def _names(words: list[str]) -> dict[str, str]:
    from flexhex.diagnosis.logs.raw import CHANNELS

    names = _pairs("--rename", words)
    for name, channel in names.items():
        if re.sub(r"\[\d+\]$", "", channel) not in ("time", *CHANNELS):
            raise UsageError(
                f"--rename {name}={channel}: no such channel; there are time,"
                f" {', '.join(CHANNELS)}, with or without an axis: theta[1]"
            )
    return names


def _pairs(option: str, words: list[str]) -> dict[str, str]:
    pairs = {}
    for word in words:
        name, _, value = word.rpartition("=")
        if not (name and value):
            raise UsageError(f"{option} {word}: write NAME=VALUE")
        pairs[name] = value
    return pairs

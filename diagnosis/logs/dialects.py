"""Column names that common robots write, as channels with the units that their makers document.

Universal Robots, RTDE's `record.py` and ur_rtde: actual_q [rad], actual_current [A] ...
KUKA, FRI's `collect_data` of pyfri: mp [rad], mt [N m], ip [rad]
Franka, fields of libfranka's RobotState: q [rad], tau_J [N m], q_d [rad]
Symbols of textbooks, which many labs write: q, qd or dq, qdd or ddq, tau, without units. Where
angles stand there, too, tau is what was measured.
Kollmorgen AKD, parameters that WorkBench records: PL.FB and VL.FB in units that the drive is set
to, IL.FB [A, RMS]
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace

from flexhex.diagnosis.logs.csv_head import Header
from flexhex.diagnosis.logs.log import Finding, Options
from flexhex.diagnosis.logs.raw import CHANNELS, split_unit


@dataclass(frozen=True)
class Dialect:
    """Names of columns without their axis, each with channel and unit; "" where it is not
    documented. known: names by which the dialect is known, all of them."""

    title: str
    known: tuple[str, ...]
    columns: Mapping[str, tuple[str, str]]


DIALECTS = (
    Dialect(
        "UR RTDE",
        ("timestamp", "actual_q"),
        {
            "timestamp": ("time", "s"),
            "actual_q": ("theta", "rad"),
            "actual_qd": ("thetad", "rad/s"),
            "target_q": ("r", "rad"),
            "actual_current": ("current", "A"),
        },
    ),
    Dialect(
        "KUKA FRI",
        ("mp", "mt"),
        {"time": ("time", "s"), "mp": ("theta", "rad"), "mt": ("tau_meas", "N m"),
         "ip": ("r", "rad")},
    ),
    Dialect(
        "Franka",
        ("q", "tau_J"),
        {"time": ("time", ""), "q": ("theta", "rad"), "dq": ("thetad", "rad/s"),
         "tau_J": ("tau_meas", "N m"), "q_d": ("r", "rad")},
    ),
    Dialect(
        "textbooks",
        ("q", "tau"),
        {"time": ("time", ""), "q": ("theta", ""), "qd": ("thetad", ""), "dq": ("thetad", ""),
         "qdd": ("thetadd", ""), "ddq": ("thetadd", ""), "tau": ("tau_meas", "")},
    ),
    Dialect(
        "Kollmorgen AKD",
        ("PL.FB", "IL.FB"),
        {"time": ("time", ""), "PL.FB": ("theta", ""), "VL.FB": ("thetad", ""),
         "IL.FB": ("current", "A"), "PL.CMD": ("r", "")},
    ),
)  # fmt: skip


def translated(header: Header, options: Options, where: str) -> tuple[Options, list[Finding]]:
    """Options that name the columns of a dialect, unless the file has channels of ours or the
    user names its columns. Units that the file lacks are filled into its header."""
    bases = [_base(name) for name in header.names]
    ours = {base.rsplit(".", 1)[-1] for base in bases} & {"theta", "tau_meas", "current"}
    if ours or options.rename:
        return options, []
    for dialect in DIALECTS:
        if set(dialect.known) <= set(bases):
            return _named(dialect, header, bases, options, where)
    return options, []


def _named(
    dialect: Dialect, header: Header, bases: list[str], options: Options, where: str
) -> tuple[Options, list[Finding]]:
    columns = {name: of for name, of in dialect.columns.items() if name in bases}
    if not any(header.units):
        in_names = [split_unit(name)[1] for name in header.names]
        units = [columns.get(base, ("", ""))[1] for base in bases]
        header.units = [own or unit for own, unit in zip(in_names, units, strict=True)]
    shown = ", ".join(
        f"{name} as {channel}" for name, (channel, _) in columns.items() if name != channel
    )
    rename = {name: channel for name, (channel, _) in columns.items()}
    text = f"columns of {dialect.title}: {shown}"
    return replace(options, rename=rename), [Finding("names", where, text, True)]


def _base(name: str) -> str:
    """A column's name without the number of its axis."""
    tail = split_unit(name.strip())[0]
    if tail in CHANNELS:
        return tail
    return re.sub(r"\s*(\[\d+\]|\(\d+\)|_\d+|\d+)$", "", tail)

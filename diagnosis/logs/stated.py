"""Units that the user gives beside those that a file states: where the two differ one is wrong."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from flexhex.diagnosis.kinds import Kind
from flexhex.diagnosis.logs.raw import Table
from flexhex.diagnosis.logs.units import each_unit, is_voltage, kind_of, size_of
from flexhex.fmus.common.errors import LogError

INSTEAD = re.compile(r"(?P<unit>.*\S)\s+not\s+(?P<file>\S.*)")
"""`deg not rad`: the unit, and the one that the file states by mistake."""
Meaning = tuple[float, Kind | str | None]
"""Size of a unit in SI, and of what it is."""


def chosen_units(
    table: Table, channel: str, given: Mapping[str, str]
) -> tuple[tuple[str, ...], str]:
    """Unit of each axis of a channel, or of the time, as the user gives it or the file states it;
    and what is said where the user's takes the place of the file's, or nothing.

    given: of the user, by channel; `theta=deg not rad` where the file's is known to be wrong. A
    unit that nobody knows (`counts`) or none at all states nothing. LogError where the two differ.
    """
    stated = (table.unit,) if channel == "time" else table.units[channel]
    if channel not in given:
        return stated, ""
    where, width = table.where, len(stated)
    stated = stated if table.stated else ("",) * width
    option = f"--unit {channel}"
    instead = INSTEAD.fullmatch(given[channel].strip())
    units = each_unit(option, channel, instead["unit"] if instead else given[channel], width)
    wrong = each_unit(option, channel, instead["file"] if instead else "", width)
    meant, said, mistaken = (
        [_meaning(channel, unit) for unit in of] for of in (units, stated, wrong)
    )
    # an unknown unit of the user's is refused when it is looked up
    other = [k for k in range(width) if None not in (meant[k], said[k]) and meant[k] != said[k]]
    of_file, of_user = _joined([stated[k] for k in other]), _joined([units[k] for k in other])
    if any(mistaken[k] != said[k] for k in other):
        correction = f"{channel}={_joined(units)} not {_joined(stated)}"
        raise LogError(
            f"{where}: {channel} is in {of_file} as the file states, but --unit says {of_user}:"
            f" leave out --unit for {channel}, or correct the file; where the file is wrong and"
            f" must stay so, --unit '{correction}' says it"
        )
    if not other:
        return units, ""
    return units, f"{channel} taken as {of_user}, as --unit says, not as {of_file} of the file"


def _meaning(channel: str, unit: str) -> Meaning | None:
    """What a unit says of a channel; None where it says nothing that is certain."""
    size = size_of(channel, unit)
    if size is not None:
        return size, "V" if is_voltage(unit) else kind_of(channel, unit)
    current = size_of("current", unit) if channel != "voltage" else None
    return None if current is None else (current, "V" if is_voltage(unit) else "A")


def _joined(units: Sequence[str]) -> str:
    """One unit for all axes, or one for each."""
    return units[0] if len(set(units)) == 1 else ",".join(units)

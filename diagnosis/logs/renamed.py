"""Names of a file's columns as its reader looks them up: what was renamed, and what is missing."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence

from flexhex.diagnosis.logs.csv_head import TIMES
from flexhex.diagnosis.logs.log import Channel, Finding
from flexhex.diagnosis.logs.raw import CHANNELS, split_unit
from flexhex.diagnosis.logs.values import NEEDED
from flexhex.fmus.common.errors import LogError

NUMBER = re.compile(r"\s*(\[\d+\]|\(\d+\)|_\d+|(?<=[A-Za-z])\d+)$")
"""Of an axis, behind the name of a column."""
EFFORT = re.compile(r"tau|tor|eff|force|mom|cur|load|^f$|^i$", re.IGNORECASE)
"""What columns of torques are often called: for an example of how to rename them."""


class Names(dict[str, str]):
    """Channels by names of the file, as the user gives them; asked: names that were looked up."""

    def __init__(self, given: Mapping[str, str]) -> None:
        super().__init__(given)
        self.asked: dict[str, None] = {}

    def get(self, name: str, default: str) -> str:  # type: ignore[override]
        """Channel of a name."""
        self.asked[name] = None
        return self[name] if super().__contains__(name) else default

    def __contains__(self, name: object) -> bool:
        self.asked[str(name)] = None
        return super().__contains__(name)

    @property
    def columns(self) -> list[str]:
        """Names of the columns; they are looked up without their numbers and units, too."""
        parts = {part for name in self.asked for part in (_base(name), split_unit(name)[0])
                 if part != name}  # fmt: skip
        return [name for name in self.asked if name not in parts]

    @property
    def unmatched(self) -> list[str]:
        """What the user renames but no column is called."""
        return [f"{name}={channel}" for name, channel in self.items() if name not in [*self.asked]]


def unmatched(where: str, names: Names) -> list[Finding]:
    """A finding on names that no column has. It is none of all logs, as others may have them."""
    if not names.unmatched:
        return []
    listed = f"--rename {' '.join(names.unmatched)} matches no column; it has"
    return [Finding("names", where, f"{listed} {', '.join(names.columns)}", False)]


def complete(
    where: str, channels: Mapping[str, Channel], unused: Sequence[str], names: Names
) -> None:
    """LogError without angles or torques, or with more of one than of the other; unused: texts on
    the columns that are no channel."""
    missing = [needed for needed in NEEDED if needed not in channels]
    wrong = [f"--rename {pair} matches none" for pair in names.unmatched]
    if missing:
        has = "; ".join([f"it has {', '.join(channels) or 'none that is known'}", *unused, *wrong])
        listed = " and ".join(f"{needed}[1], {needed}[2] ..." for needed in missing)
        raise LogError(
            f"{where}: no channels {listed} ({has}): {_remedy(missing, channels, names)}"
        )
    n, m = channels["theta"].width, channels["tau_meas"].width
    if n != m:
        of, other = ("torque", "tau_meas") if m < n else ("angle", "theta")
        axis, said = min(n, m) + 1, "".join(f"; {text}" for text in (*unused, *wrong))
        raise LogError(
            f"{where}: {n} angles but {m} torques: axis {axis} has no {of} ({other}[{axis}]{said}):"
            f" add a column {other}[{axis}], or rename one, --rename 'COLUMN={other}[{axis}]'"
        )


def _remedy(missing: Sequence[str], channels: Mapping[str, Channel], names: Names) -> str:
    if missing == ["tau_meas"] and "tau" in channels:
        return "--rename 'tau=tau_meas' takes the commanded torques in their place"
    bases = [_base(name) for name in names.columns if NUMBER.search(name)]
    known = {*CHANNELS, *names, *TIMES}
    free = [base for base in Counter(bases) if base not in known]
    efforts = [base for base in free if EFFORT.search(base)]
    angles = [base for base in free if base not in efforts]
    found = {"theta": angles[:1], "tau_meas": efforts[:1]}
    if all(found[needed] for needed in missing):
        words = " ".join(f"--rename {found[needed][0]}={needed}" for needed in missing)
        return (
            f"rename the columns in the file, or all that are numbered, for instance with {words}"
        )
    needed = missing[0]
    return (
        f"rename a column in the file or with --rename 'COLUMN={needed}[1]', or all that are"
        f" numbered with --rename NAME={needed}"
    )


def _base(name: str) -> str:
    """A name without the number of its axis."""
    return NUMBER.sub("", split_unit(name)[0].rsplit(".", 1)[-1])

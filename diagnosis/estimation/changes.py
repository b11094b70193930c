"""Changed parameters that a diagnosis found, before all parameters are fitted.

What the file says of such a parameter counts so much less that the value found is one standard
deviation away. A payload that only some runs show is fitted on these runs.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from flexhex.diagnosis.basemodels.base import Base
from flexhex.diagnosis.estimation.friction import PARAMETER
from flexhex.diagnosis.runs.run import Run
from flexhex.fmus.common.effects import library


@dataclass(frozen=True)
class Change:
    """A parameter with how far it is from its file [unit]; runs: those that show it, if not all."""

    parameter: str
    moved: float
    runs: tuple[str, ...] = ()


def changes_of(listed: Sequence[Mapping[str, Any]]) -> tuple[Change, ...]:
    """Of a diagnosis as data. KeyError, TypeError or ValueError for other data."""
    return tuple(
        Change(one["parameter"], float(one["to"]) - float(one["from"]), tuple(one["runs"]))
        for one in listed
    )


def loosened(base: Base, changes: Sequence[Change]) -> tuple[Base, list[str]]:
    """The base model in which the file's values of changed parameters count less; what was done,
    in sentences."""
    lasting = {one.parameter: abs(one.moved) for one in changes if not one.runs}
    linear, notes, freed = list(base.linear), list[str](), list[str]()
    for place, known in enumerate(linear):
        moved = lasting.pop(known.name, 0.0)
        if 0 < known.tolerance < moved < np.inf:
            linear[place] = replace(known, wider=moved / known.tolerance)
            freed.append(known.name)
    if freed:
        notes.append(
            f"{', '.join(freed)}: changed, as the diagnosis found: the file's value counts so much"
            " less"
        )
    lasting = {name: by for name, by in lasting.items() if not _is_effect(name)}
    if lasting:
        places = "--tolerance geometry=0.002 fits places of joints, gravity=0.002 a tilt"
        notes.append(
            f"{', '.join(lasting)}: changed, as the diagnosis found, but nothing that is fitted"
            f" here ({places})"
        )
    looser = copy(base)
    looser.linear = tuple(linear)
    return looser, notes


def _is_effect(name: str) -> bool:
    """Whether a parameter is a gain of friction or of another effect: these are fitted anew."""
    return name.partition("[")[0] in PARAMETER.values() or name.partition(".")[0] in library()


def loaded(runs: Sequence[Run], changes: Sequence[Change]) -> tuple[list[Run], list[str]]:
    """The runs with payloads that a diagnosis found on some of them; a sentence for each."""
    listed, notes = list(runs), list[str]()
    for names in dict.fromkeys(one.runs for one in changes if one.runs):
        bit = 1 << max(run.loads for run in listed).bit_length()
        known = {Path(name).name for name in names}
        carry = [run for run in listed if Path(run.name).name in known]
        if len(carry) == len(listed) or not carry:
            notes.append(
                f"a payload on {', '.join(sorted(known))}, as the diagnosis found, is not fitted:"
                f" {'all' if carry else 'none'} of these runs are its runs"
            )
            continue
        listed = [replace(r, loads=r.loads | bit) if r in carry else r for r in listed]
        shown = ", ".join(Path(run.name).name for run in carry)
        notes.append(f"{shown}: with a payload, as the diagnosis found: fitted as `payload`")
    return listed, notes

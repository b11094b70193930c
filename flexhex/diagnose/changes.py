"""Changed parameters and payloads in sentences."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from flexhex.diagnose.numbers import listed, measured, number
from flexhex.diagnose.sizes import SEVERAL
from flexhex.diagnose.titles import effort
from flexhex.diagnosis.kinds import with_unit
from flexhex.diagnosis.result.verdict import NORMAL, Changed, Diagnosis, Tolerated

MEANINGS = {"gravity": " (the machine is tilted about this axis of its foot)"}
"""What parameters mean of which the name alone says little, by its first word."""


def other_values(diagnosis: Diagnosis) -> list[str]:
    """A sentence on the parameters that are others than the machine file says, or none."""
    parts, everywhere = [], [c for c in diagnosis.changed if not c.runs]
    for c in everywhere[:SEVERAL]:
        means = MEANINGS.get(c.parameter.split(".")[0], "")
        nominal = with_unit(number(c.nominal), c.estimate.unit)
        parts.append(f"{c.parameter}{means} is {measured(c.estimate)}, not {nominal}")
    more = len(everywhere) - SEVERAL
    if more > 0:
        parts.append(f"{more} more")
    return [f"Parameters that deviate from the machine file: {'; '.join(parts)}."] if parts else []


def allowed(diagnosis: Diagnosis) -> list[str]:
    """Sentences on what is no finding though it makes a torque: what tolerances allow, and what is
    beyond them, but does not stand out by itself."""
    inside = [one for one in diagnosis.tolerated if one.off <= NORMAL]
    beyond = [one for one in diagnosis.tolerated if one.off > NORMAL]
    return [
        *_tolerated(diagnosis, "No finding, as the tolerances allow it", inside),
        *_tolerated(diagnosis, "Beyond the tolerance, but no finding by itself", beyond),
    ]


def _tolerated(diagnosis: Diagnosis, said: str, those: Sequence[Tolerated]) -> list[str]:
    parts = []
    for one in those[:SEVERAL]:
        means = MEANINGS.get(one.parameter.split(".")[0], "")
        tolerance = with_unit(f"{one.tolerance:.3g}", one.estimate.unit)
        value = f"{one.parameter}{means} is {measured(one.estimate)}, tolerance {tolerance}"
        of = f"{effort([diagnosis.residual.units[one.axis - 1]])} of axis {one.axis}"
        parts.append(f"{value}, which makes {number(100 * one.share, 2)} % of the {of}")
    if (more := len(those) - SEVERAL) > 0:
        parts.append(f"{more} more, which make less")
    return [f"{said}: {'; '.join(parts)}."] if parts else []


def felt(diagnosis: Diagnosis) -> list[Changed]:
    """Parameters that changed, without those that no torque feels: they are 0, without interval."""
    return [c for c in diagnosis.changed if c.estimate.value or any(c.estimate.ci95)]


def carriers(diagnosis: Diagnosis) -> list[str]:
    """A sentence for each payload that no log announces: what it is, and on which runs."""
    sets = dict.fromkeys(c.runs for c in diagnosis.changed if c.runs)
    sentences = []
    for runs in sets:
        same = [c for c in felt(diagnosis) if c.runs == runs]
        own = [f"{c.parameter} {measured(c.estimate)}" for c in same]
        names = listed([Path(run).name for run in runs])
        sentences.append(f"A payload that no log announces was on {names}: {', '.join(own)}.")
    return sentences

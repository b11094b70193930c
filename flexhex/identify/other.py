"""`flexhex identify` of any base model but the hexapod: what it shows."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from flexhex.diagnose.numbers import number
from flexhex.diagnose.titles import capital, effort, readable
from flexhex.diagnosis.estimation.excitation import Excitation
from flexhex.diagnosis.estimation.records import Errors, Identified
from flexhex.diagnosis.kinds import units_of
from flexhex.diagnosis.result.estimates import Parameter, summed
from flexhex.identify.simulated import simulation_parts
from flexhex.identify.view import with_deviation
from flexhex.output.parts import Part, Sentence, Titled, print_parts
from flexhex.output.tables import Column, Value, console, printed

NARROWED = 10
"""Sums that are shown of what a motion would narrow."""
AGREES = 2
"""Tolerances within which the file's values agree with the runs."""
WIDE = 34
"""Characters of a sum that the terminal shows, so that its numbers stand beside it."""
COLUMNS = (
    Column("name", ""),
    Column("value", "estimate ± 95 %", right=True),
    Column("unit", "unit"),
    Column("file", "file", "", ".4g"),
    Column("shift", "difference / tolerance", "", "+.1f"),
)
FROM_FILE = ("file", "shift")
"""Columns that a base model without a file leaves empty."""
NARROWER = (
    Column("name", ""),
    Column("now", "± 95 % now", "", ".2g"),
    Column("then", "then", "", ".2g"),
    Column("unit", "unit"),
)


@dataclass(frozen=True)
class Pointers:
    """Where the parameters are that a view leaves out, and the sums that it cuts."""

    hidden: str = "--all shows them"
    sums: str = "--all writes them out"


TERMINAL = Pointers()


def identified_json(
    identified: Identified, written: Sequence[str] | None = None, more: Excitation | None = None
) -> str:
    """All of it as JSON; written: files, of an answer; more: a motion and what it would narrow."""
    data = identified.data() | ({} if written is None else {"written": list(written)})
    if more is not None:
        data["next"] = [{"name": one.name, "narrower": share} for one, share in more.narrowed]
    return json.dumps(data, indent=2)


def print_excitation(more: Excitation) -> None:
    """What one more run is expected to narrow, the most of it."""
    print_parts(console(), excitation_parts(more))


def excitation_parts(more: Excitation) -> list[Part]:
    """The same, part by part."""
    rows: list[Mapping[str, Value]] = []
    for one, share in more.narrowed[:NARROWED]:
        low, high = one.estimate.ci95
        wide = max(high - one.estimate.value, (high - low) / 2)
        rows.append({"name": short(one.terms), "now": wide, "then": share * wide,
                     "unit": printed(one.estimate.unit)})  # fmt: skip
    motion = more.motion
    n, (length, ts) = motion.r.shape[1], (motion.time[-1], motion.ts)
    units, axes = dict.fromkeys(units_of(motion, n, "rad")), "r[1]" + f" to r[{n}]" * (n > 1)
    return [
        Titled("One more run, along the motion written", NARROWER, rows),
        Sentence(
            f"The motion is a reference for each axis, {axes} in {' and '.join(units)},"
            f" every {1e3 * ts:.4g} ms for {length:.3g} s. It begins and ends at rest, and stays"
            " within the positions, rates and accelerations of the logs. Collisions are not"
            f" checked. Run it {motion.meta['passes']} times, so that what repeats shows, and give"
            " the new logs with the old ones; `then` is after the first."
        ),
    ]


def print_identified(identified: Identified, every: bool = False) -> None:
    """Parameters, sums that the runs determine, errors. every: what they do not determine too."""
    print_parts(console(), identified_parts(identified, every))


def identified_parts(
    identified: Identified, every: bool = False, rest: Pointers = TERMINAL
) -> list[Part]:
    """The same, part by part; rest: where that is which it leaves out."""
    parts: list[Part] = []
    if identified.doubt:
        parts.append(Sentence(f"{capital(readable(identified.doubt))}\n"))
    parts += _parameters("Parameters", identified.parameters, every)
    exact = {one.name for one in identified.parameters if one.exact}
    sums = [one for one in identified.combinations if len({n for n, _ in one.terms} - exact) > 1]
    if sums:
        parts += _parameters("Base parameters: sums that act as one", sums, every)
        if not every and any(one.determined and short(one.terms) != one.name for one in sums):
            parts.append(Sentence(f"Long sums are cut ({rest.sums})."))
        parts += [Sentence(text) for text in _agreement(identified, sums)]
    if exact:
        stay = "stay" if len(exact) > 1 else "stays"
        parts.append(
            Sentence(
                f"{len(exact)} of {len(identified.parameters)} parameters {stay} at the file's"
                " values, which are exact (a tolerance of 0)."
            )
        )
    hidden = [one for one in identified.parameters if not one.determined and not one.exact]
    if hidden and not every:
        parts.append(
            Sentence(
                f"{len(hidden)} of {len(identified.parameters)} parameters are not determined by"
                f" these motions by themselves ({rest.hidden})."
            )
        )
    if silent := [name for name in identified.silent if name not in exact]:
        parts.append(Sentence(f"No torque depends on {_listed(silent)}."))
    low, high = identified.delay.ci95
    if not low <= 0 <= high:
        parts.append(Sentence(late(identified.delay.value)))
    parts.append(_errors(identified))
    if identified.simulation is not None:
        parts += simulation_parts(identified.simulation, effort(identified.units))
    parts += [Sentence(f"finding: {readable(text)}") for text in identified.findings]
    parts += [Sentence(f"note: {readable(text)}") for text in identified.notes]
    return parts


def _agreement(identified: Identified, sums: Sequence[Parameter]) -> list[str]:
    """What the sums say of the file that a reader asks first: whether its masses are right."""
    told = [one for one in sums if one.determined and math.isfinite(one.shift)]
    off = [one for one in told if abs(one.shift) > AGREES]
    texts = []
    if off:
        are = "is" if len(off) == 1 else "are"
        texts.append(
            f"{len(off)} of {len(told)} sums that the file has values of {are} more than"
            f" {AGREES:g} of its tolerances off."
        )
    elif told:
        known = "sum" if len(told) == 1 else f"{len(told)} sums"
        texts.append(f"The file's values of the {known} are within {AGREES:g} of its tolerances.")
    masses = [one for one in identified.parameters if one.name.endswith(".m") and not one.exact]
    if masses and not any(one.determined for one in masses):
        texts.append(
            "No body's mass is determined by itself: other values of its sums would do as well."
        )
    return texts


def late(delay: float) -> str:
    """A sentence on a delay [s] of the torques behind the angles."""
    by, way = f"by {1e3 * abs(delay):.2g} ms", "lags" if delay > 0 else "leads"
    return f"The torque channel {way} the angles {by}, or friction of another form looks like that."


def _parameters(title: str, listed: Sequence[Parameter], every: bool) -> list[Part]:
    shown = [one for one in listed if every or one.determined]
    parts: list[Part] = []
    if shown:
        rows = [_row(one, every) for one in shown]
        columns = [
            c for c in COLUMNS if c.key not in FROM_FILE or any(r[c.key] != "" for r in rows)
        ]
        parts.append(Titled(title, columns, rows))
    if any(_starred(one) for one in shown):
        parts.append(Sentence("* not determined by these motions by itself"))
    return parts


def _row(one: Parameter, every: bool) -> Mapping[str, Value]:
    wide = (one.estimate.ci95[1] - one.estimate.ci95[0]) / 2
    open_end = max(one.estimate.ci95[1] - one.estimate.value, wide)
    value = with_deviation(one.estimate.value, open_end)
    unknown = math.isinf(one.tolerance) and one.file == 0
    return {
        "name": (one.name if every else short(one.terms)) + " *" * _starred(one),
        "value": value if math.isfinite(open_end) else "any",
        "unit": printed(one.estimate.unit),
        "file": "" if unknown else one.file,
        "shift": one.shift if math.isfinite(one.shift) else "",
        "class": "yellow" if _starred(one) else "",
    }


def _starred(one: Parameter) -> bool:
    """Whether the runs could have said more of it."""
    return not one.determined and not one.exact


def short(terms: Sequence[tuple[str, float]]) -> str:
    """A sum with as many of its terms as fit."""
    texts = [summed(terms, first) for first in range(1, len(terms) + 1)]
    fitting = [text for text in texts if len(text) <= WIDE]
    return fitting[-1] if fitting else texts[0]


def _errors(identified: Identified) -> Titled:
    both: list[tuple[str, Errors]] = [("runs", identified.errors)]
    if identified.held_out is not None:
        both.append(("held out", identified.held_out))
    called = effort(identified.units)
    columns = [Column("axis", "axis"), Column("torque", f"{called} RMS", right=True)]
    for name, _ in both:
        columns.append(Column(f"{name}: file", f"{name}: file", "%", ".3g"))
        columns.append(Column(f"{name}: identified", "identified", "%", ".3g"))
    rows: list[Mapping[str, Value]] = []
    for i, unit in enumerate(identified.units):
        left = {f"{name}: file": 100 * float(e.file[i]) for name, e in both}
        left |= {f"{name}: identified": 100 * float(e.fitted[i]) for name, e in both}
        torque = f"{number(float(identified.errors.torque[i]))} {unit}"
        rows.append({"axis": str(i + 1), "torque": torque, **left})
    title = f"Share of the {called} that is left (RMS, of the {called} with its mean)"
    return Titled(title, columns, rows)


def has_file(identified: Identified) -> bool:
    """Whether anything was known of the parameters before."""
    return any(one.exact or 0 < one.tolerance < math.inf for one in identified.parameters)


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names) if len(names) < 2 else f"{', '.join(names[:-1])} or {names[-1]}"

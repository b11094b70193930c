"""Effects that were found, as rows of a table and what is said below it."""

from __future__ import annotations

import re

from flexhex.diagnose.numbers import listed, measured, number, percent
from flexhex.diagnose.titles import title, where
from flexhex.diagnosis.result.estimates import Estimate
from flexhex.diagnosis.result.verdict import Diagnosis
from flexhex.fmus.common.effects import library
from flexhex.output.tables import printed

EFFECTS = ("effect", "where", "parameters, 95 %", "explains")
Rows = list[tuple[str, ...]]


def effect_rows(diagnosis: Diagnosis) -> Rows:
    """A row for each place that has an effect; its name and share stand in the first one. A
    parameter that the runs do not determine is in none: see `undetermined`; nor is one that says
    nothing to a reader."""
    rows: Rows = []
    for e in diagnosis.effects:
        name, share = title(e.id) + (" *" if e.rivals else ""), percent(e.share)
        for axis, estimates in e.parts or ((0, e.parameters),):
            told = {key: v for key, v in estimates.items() if v.told and v.determined}
            known = [f"{key} = {_in_words(e.id, key, v) or measured(v)}" for key, v in told.items()]
            place = where((axis,) if axis else e.axes, short=True)
            rows.append((name, place, ", ".join(known), share))
            name = share = ""
    return rows


def _in_words(effect: str, key: str, value: Estimate) -> str:
    """A shape whose whole numbers mean something: `axis 2`."""
    shapes = library()[effect].shapes if effect in library() else ()
    name = re.split(r"[\[#]", key)[0]
    return next((shape.said(value.value) for shape in shapes if shape.name == name), "")


def undetermined(diagnosis: Diagnosis) -> list[str]:
    """A line on each parameter of an effect that the runs do not determine, with its axes and what
    it is in the fit."""
    lines = []
    for e in diagnosis.effects:
        parts = e.parts or ((0, e.parameters),)
        for key in dict.fromkeys(key for _, estimates in parts for key in estimates):
            open_ = {axis: v[key] for axis, v in parts if key in v and _open(v[key])}
            values = dict.fromkeys(f"{number(v.value)} {printed(v.unit)}" for v in open_.values())
            if open_:
                there = f" on {where(tuple(sorted({*open_} - {0})))}" if {*open_} != {0} else ""
                text = f"{title(e.id)}: {key} is not determined{there}"
                lines.append(f"{text} (in the fit: {listed([v.strip() for v in values])})")
    return lines


def _open(value: Estimate) -> bool:
    return value.told and not value.determined


def rivalry(diagnosis: Diagnosis) -> list[str]:
    """The footnote of each effect that has rivals."""
    lines = []
    for e in diagnosis.effects:
        if e.rivals:
            others = listed([title(name) for name in e.rivals], "or")
            here = f" on {where(e.open)}" if {*e.open} < {*e.axes} else ""
            line = f"* these runs do not distinguish {title(e.id)}{here} from {others}"
            if e.experiment:
                line += f"; an experiment that does: {e.experiment}"
            lines.append(line)
    return lines

"""A diagnosis in the terminal and as JSON: the verdict first, then what it rests on."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console

from flexhex.diagnose.changes import allowed, felt
from flexhex.diagnose.effects import EFFECTS, Rows, effect_rows, rivalry, undetermined
from flexhex.diagnose.next import Invocation, next_steps
from flexhex.diagnose.numbers import number, percent, side_by_side
from flexhex.diagnose.titles import effort, readable
from flexhex.diagnose.words import verdict
from flexhex.diagnosis.result.verdict import WORSE, Diagnosis, Residual, rms
from flexhex.output.parts import Part, Sentence, Titled, print_parts, say
from flexhex.output.tables import Column, printed

STYLES = {"none": "green", "cannot tell": "yellow", "unknown": "red"}
SIDES = ("before", "after")
LOOPS = {"model": "extended model (a prediction)", "machine": "machine"}
"""Plants of the closed loop, as `flexhex.diagnose.rebuild` calls them."""
MOST_FINDINGS, MOST_NAMES = 10, 4
"""Findings, and names of parameters in a sentence, that are shown; the report has all findings."""
CHANGED = ("parameter", "machine file", "estimate", "95 %", "unit")
IDENTIFIED = ("parameter", "estimate", "95 %", "unit")


def print_diagnosis(
    diagnosis: Diagnosis, invocation: Invocation, out: Console | None = None
) -> None:
    """Verdict, effects, rivals, parameters, residual, notes, findings, what to do next."""
    out = out or Console()
    print_parts(out, diagnosis_parts(diagnosis))
    _print_findings(out, [readable(text) for text in diagnosis.findings])
    _print_steps(out, diagnosis, invocation)


def diagnosis_parts(diagnosis: Diagnosis) -> list[Part]:
    """Verdict, effects, rivals, parameters, residual and notes, part by part."""
    style = STYLES.get(diagnosis.verdict, "bold")
    headline = f"Verdict: {diagnosis.verdict}. {verdict(diagnosis)}"
    parts: list[Part] = [Sentence(headline, style)]
    if diagnosis.effects:
        parts.append(titled("Effects that the model lacks", EFFECTS, effect_rows(diagnosis)))
    parts += map(Sentence, (*undetermined(diagnosis), *rivalry(diagnosis)))
    if diagnosis.changed:
        rows = changed_rows(diagnosis)
        parts.append(titled("Parameters that deviate from the machine file", CHANGED, rows))
    if diagnosis.parameters:
        if rows := parameter_rows(diagnosis):
            parts.append(titled(parameters_title(diagnosis), IDENTIFIED, rows))
        parts += map(Sentence, vague(diagnosis))
    residual = diagnosis.residual
    if np.isfinite(residual.before).any():
        columns, rows = residual_columns(residual), residual_rows(diagnosis)
        parts.append(titled(residual_title(residual), columns, rows, bool(residual.unit)))
    lines = (*allowed(diagnosis), *shown_lines(diagnosis.shown), *remarks(diagnosis))
    return [*parts, *map(Sentence, lines)]


def print_applied(diagnosis: Diagnosis, report: Path, invocation: Invocation) -> None:
    """What was written, after the summary was shown already."""
    out = Console()
    for text in shown_lines(diagnosis.shown):
        say(out, text)
    if diagnosis.machine:
        say(out, f"machine  {diagnosis.machine}")
    _print_steps(out, diagnosis, invocation)
    say(out, f"report   {report}")


def changed_rows(diagnosis: Diagnosis) -> Rows:
    """From what to what."""
    rows: Rows = []
    for c in felt(diagnosis):
        e = c.estimate
        rows.append((c.parameter, number(c.nominal, 4), *side_by_side(e), printed(e.unit)))
    return rows


def parameter_rows(diagnosis: Diagnosis) -> Rows:
    """The base model's parameters that the runs determine, as identified."""
    rows: Rows = []
    for one in diagnosis.parameters:
        if one.determined:
            e = one.estimate
            rows.append((one.name, *side_by_side(e), printed(e.unit)))
    return rows


def parameters_title(diagnosis: Diagnosis) -> str:
    """What stands above them."""
    return "Parameters of the base model" + ", beside what was found" * bool(diagnosis.effects)


def vague(diagnosis: Diagnosis) -> tuple[str, ...]:
    """A sentence on those that the runs do not determine: their names if they are few."""
    names = [one.name for one in diagnosis.parameters if not (one.determined or one.exact)]
    if not names:
        return ()
    which = f"{len(names)} of {len(diagnosis.parameters)} parameters"
    which += f" ({', '.join(names)})" if len(names) <= MOST_NAMES else ""
    one = len(names) == 1
    verb, selves = ("is", "itself") if one else ("are", "themselves")
    return (f"{which} {verb} not determined by these motions by {selves}.",)


def judged(diagnosis: Diagnosis) -> Mapping[str, np.ndarray[Any, Any]]:
    """torque, before, after, non-repeatable (n,) on the held-out runs where there are any.

    Where only parameters changed, `before` is the model with those of the machine file.
    """
    residual = diagnosis.residual
    if diagnosis.verdict == "changed":
        nominal = residual.held_out.get("nominal", residual.nominal)
        others = {k: v for k, v in residual.held_out.items() if k != "before"}
        residual = replace(residual, before=nominal, held_out=others)
    own = {
        name: getattr(residual, name) for name in ("torque", "before", "after", "non_repeatable")
    }
    return {**own, **{name: residual.held_out[name] for name in own if name in residual.held_out}}


def residual_title(residual: Residual) -> str:
    """Title of the table: held-out runs where there are any."""
    on = "held-out runs" if residual.held_out else "the runs of the fit"
    return f"Residual RMS{f' [{residual.unit}]' if residual.unit else ''} on {on}"


def axis_names(residual: Residual) -> list[str]:
    """Numbers of the axes, with their units where these differ."""
    units = ["" if residual.unit else f" [{unit}]" for unit in residual.units]
    return [f"{i}{unit}" for i, unit in enumerate(units, start=1)]


def closed(before: float, after: float, non_repeatable: float) -> str:
    """Fraction of the repeatable residual's mean square that is explained; "" where there is none.

    A non-repeatable residual that is not known (NaN: no run was repeated) counts as zero.
    """
    non_repeatable = non_repeatable if math.isfinite(non_repeatable) else 0.0
    above = before**2 - non_repeatable**2
    if not (math.isfinite(above) and math.isfinite(after)) or above <= 0.02 * before**2:
        return ""
    share = (before**2 - max(after, non_repeatable) ** 2) / above
    return percent(max(share, 0.0)) if after < WORSE * before else f"{after / before:.2f} × before"


def residual_columns(residual: Residual) -> tuple[str, ...]:
    """Names of their columns."""
    mean = f"{effort(residual.units)} about its mean"
    return "axis", mean, "before", "after", "non-repeatable", "explained"


def residual_rows(diagnosis: Diagnosis) -> Rows:
    """A row for each axis, then all of them together where they have one unit."""
    residual, values = diagnosis.residual, judged(diagnosis)
    before, after, non_repeatable = values["before"], values["after"], values["non_repeatable"]
    columns = (values["torque"], before, after, non_repeatable)
    rows: Rows = []
    for i, name in enumerate(axis_names(residual)):
        part = closed(float(before[i]), float(after[i]), float(non_repeatable[i]))
        rows.append((name, *(number(float(v[i])) for v in columns), part))
    if len(rows) > 1 and residual.unit:
        part = closed(rms(before), rms(after), rms(non_repeatable))
        rows.append(("all", *(number(rms(v)) for v in columns), part))
    return rows


def shown_lines(shown: Mapping[str, Any]) -> list[str]:
    """The replayed runs and the closed loops in a line each, where they were run."""
    lines = []
    for run, residuals in shown.get("simulation_residual", {}).items():
        before, after = (rms(np.asarray(residuals[side], dtype=np.float64)) for side in SIDES)
        lines.append(
            f"Rebuilt simulation of {Path(run).name}: residual {number(before)} N m before,"
            f" {number(after)} N m after"
        )
    for kind, sides in shown.get("closed_loop", {}).items():
        (e, tau), (e_after, tau_after) = ((sides[s]["e"], sides[s]["tau_fb"]) for s in SIDES)
        lines.append(
            f"Closed loop on the {LOOPS.get(kind, kind)}: tracking error {number(e)} µrad before,"
            f" {number(e_after)} µrad after; feedback {number(tau)} and {number(tau_after)} N m"
        )
    return lines


def remarks(diagnosis: Diagnosis) -> tuple[str, ...]:
    """Notes that the verdict has not said already."""
    notes = diagnosis.notes[:-1] if diagnosis.verdict == "cannot tell" else diagnosis.notes
    return tuple(readable(note) for note in notes)


def _print_findings(out: Console, findings: Sequence[str]) -> None:
    if not findings:
        return
    out.print("\n[bold]Findings in the logs[/]")
    for text in findings[:MOST_FINDINGS]:
        say(out, f"  {text}")
    if len(findings) > MOST_FINDINGS:
        say(out, f"  and {len(findings) - MOST_FINDINGS} more in the report")


def _print_steps(out: Console, diagnosis: Diagnosis, invocation: Invocation) -> None:
    steps = next_steps(diagnosis, invocation)
    if steps:
        out.print("\n[bold]What to do next[/]")
    for text, words in steps:
        say(out, f"  {text}")
        if words:
            say(out, f"    {words}")


def titled(
    heading: str, names: Sequence[str], rows: Sequence[Sequence[str]], total: bool = False
) -> Titled:
    """A table of texts; columns of words stand left. total: a line before the last row."""
    words = ("effect", "where", EFFECTS[2], "parameter", "unit", "axis", "indistinguishable from")
    columns = [Column(name, name, right=name not in words, fold=True) for name in names]
    return Titled(heading, columns, [dict(zip(names, r, strict=True)) for r in rows], total)


def diagnosis_json(diagnosis: Diagnosis, report: Path) -> str:
    """Everything for a program; a figure that is no number is null."""
    data = {**diagnosis.data(), "sentence": verdict(diagnosis), "report": str(report)}
    return json.dumps(plain(data), indent=2, allow_nan=False)


def plain(value: Any) -> Any:
    """Arrays as lists, numbers that are none as None: what JSON can hold."""
    if isinstance(value, Mapping):
        return {str(key): plain(v) for key, v in value.items()}
    if isinstance(value, np.ndarray | list | tuple):
        return [plain(v) for v in value]
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value

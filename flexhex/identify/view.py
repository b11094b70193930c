"""What `flexhex identify` shows: estimates beside the machine file, or the same as JSON."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping

import numpy as np
from rich.console import Console

from flexhex.diagnosis.estimation.identify import Fit
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.model.parameters import Parameter, base_parameters, parameters, term
from flexhex.output.tables import GROUP, Column, Value, console, printed, table

HOPELESS = 0.5
"""Share of undetermined parameters beyond which a fit is warned of."""
COGGING = ("a", "b")
"""Terms of the cogging amplitudes, 108 of the 162: one line for each actuator, unless all rows are
wanted."""
Row = tuple[Parameter, float, float, float, float]
"""Parameter, estimate, standard deviation, machine file's value, difference in deviations."""
COLUMNS = (
    Column("parameter", "parameter"),
    Column("estimate", "estimate ± std", right=True),
    Column("file", "machine file", "", ".4g"),
    Column("apart", "difference / std", "", "+.1f"),
    Column("unit", "unit"),
)


def print_fit(machine: Machine, fit: Fit, every: bool = False) -> None:
    """Estimates with standard deviations beside the machine file's values, body by body.

    every: the cogging amplitudes as well, which otherwise are one line for each actuator.
    """
    listed: list[Mapping[str, Value]] = []
    rows = compared(machine, fit)
    for body in dict.fromkeys(group(par) for par, *_ in rows):
        mine = [row for row in rows if group(row[0]) == body]
        hidden = [] if every else [row for row in mine if term(row[0].name) in COGGING]
        listed.append({GROUP: body})
        listed += [_row(row, fit) for row in mine if row not in hidden]
        if hidden:
            listed.append(_summary(hidden, fit))
    out = console()
    out.print(table("Least-squares estimate", COLUMNS, listed))
    _print_quality(out, fit)
    warn_of(out, fit)


def group(par: Parameter) -> str:
    """Body of a parameter, the upper arms together."""
    return "upper arms" if par.body.startswith("upper arm") else par.body


def compared(machine: Machine, fit: Fit) -> list[Row]:
    """A row for each parameter."""
    listed, nominal = parameters(machine), base_parameters(machine)
    rows = []
    for par, value, std, file in zip(listed, fit.p, fit.std, nominal, strict=True):
        apart = (value - file) / std if std > 0 else math.nan
        rows.append((par, float(value), float(std), float(file), float(apart)))
    return rows


def _row(row: Row, fit: Fit) -> Mapping[str, Value]:
    par, value, std, file, apart = row
    loose = par.name in fit.undetermined
    return {
        "parameter": par.name + (" *" if loose else ""),
        "estimate": with_deviation(value, std),
        "file": file,
        "apart": apart,
        "unit": printed(par.unit),
        "class": "yellow" if loose else "",
    }


def _summary(hidden: list[Row], fit: Fit) -> Mapping[str, Value]:
    """One line for the cogging amplitudes of an actuator."""
    farthest = max(hidden, key=lambda row: abs(row[4]) if math.isfinite(row[4]) else -1.0)
    loose = sum(row[0].name in fit.undetermined for row in hidden)
    return {
        "parameter": f"cogging, {len(hidden)} in all" + (f", {loose} *" if loose else ""),
        "estimate": f"most: {farthest[0].name}",
        "file": "",
        "apart": farthest[4],
        "unit": printed(hidden[0][0].unit),
    }


def with_deviation(value: float, std: float) -> str:
    """`0.0123 ± 0.0004`: two digits of a deviation that begins with 1, one of any other."""
    if not (math.isfinite(std) and std > 0):
        return f"{value:.5g}"
    place = -math.floor(math.log10(std)) + (f"{std:e}"[0] == "1")
    if place > 6:
        return f"{value:.5g} ± {std:.1g}"
    digits = max(place, 0)
    return f"{round(value, digits) + 0.0:.{digits}f} ± {std:.{digits}f}"


def _print_quality(out: Console, fit: Fit) -> None:
    rms = ", ".join(f"{1e3 * r:.2f}" for r in fit.residual_rms)
    out.print(f"Residual RMS of joints 1 to {len(fit.residual_rms)}: {rms} mN m", highlight=False)
    out.print(f"Condition number of the normalised columns: {fit.condition:.3g}", highlight=False)
    if fit.undetermined:
        text = (
            f"[yellow]*[/] {len(fit.undetermined)} of {len(fit.p)} parameters are not determined:"
            " two standard deviations exceed the parameter's size"
        )
        out.print(text, highlight=False)


def warn_of(out: Console, fit: Fit) -> None:
    """What the fit itself warns of, and a line when most parameters are not determined: whatever is
    made of p then is luck."""
    for text in fit.warnings:
        out.print(f"[red]warning[/]: {text}", highlight=False)
    if len(fit.undetermined) > HOPELESS * len(fit.p):
        out.print(
            f"[red]warning[/]: {len(fit.undetermined)} of {len(fit.p)} parameters are not"
            " determined by the log they were fitted to, p means little: move all joints, wider"
            " and longer",
            highlight=False,
        )


def fit_json(machine: Machine, fit: Fit) -> str:
    """The fit as JSON."""
    rows = [
        {
            "name": par.name,
            "unit": par.unit,
            "body": par.body,
            "value": value,
            "std": std,
            "machine_file": file,
        }
        for par, value, std, file, _ in compared(machine, fit)
    ]
    return json.dumps(
        {
            "parameters": rows,
            "residual_rms": {"unit": "N m", "joints": np.asarray(fit.residual_rms).tolist()},
            "condition": fit.condition,
            "undetermined": list(fit.undetermined),
            "warnings": list(fit.warnings),
        },
        indent=2,
    )

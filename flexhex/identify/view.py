"""What `flexhex identify` shows: estimates with their deviations, or the same as JSON."""

from __future__ import annotations

import json

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from flexhex.diagnosis.identify import Fit
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.model.parameters import parameters

HOPELESS = 0.5
"""Share of undetermined parameters beyond which a fit is warned of."""


def print_fit(machine: Machine, fit: Fit) -> None:
    """All estimates with unit and standard deviation."""
    table = Table(title="Least-squares estimate", box=SIMPLE_HEAD)
    for name in ("parameter", "body", "unit"):
        table.add_column(name)
    for name in ("estimate", "± std"):
        table.add_column(name, justify="right")
    for par, value, std in zip(parameters(machine), fit.p, fit.std, strict=True):
        style = "yellow" if par.name in fit.undetermined else None
        table.add_row(par.name, par.body, par.unit, f"{value:.5g}", f"{std:.1g}", style=style)
    out = Console()
    out.print(table)
    rms = ", ".join(f"{1e3 * r:.2f}" for r in fit.residual_rms)
    out.print(f"residual of the joints (mN m): {rms}; condition {fit.condition:.3g}")
    warn_of(out, fit)
    if fit.undetermined:
        out.print("[yellow]yellow[/]: not determined by itself: its deviation exceeds its size")


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
        {"name": par.name, "unit": par.unit, "value": float(p), "std": float(s)}
        for par, p, s in zip(parameters(machine), fit.p, fit.std, strict=True)
    ]
    return json.dumps(
        {
            "parameters": rows,
            "residual_rms": {"unit": "N m", "joints": fit.residual_rms.tolist()},
            "condition": fit.condition,
            "undetermined": list(fit.undetermined),
            "warnings": list(fit.warnings),
        },
        indent=2,
    )

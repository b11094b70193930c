"""What a simulation shows: tracking error and feedback torque, time in each FMU, faults."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from rich.console import Console, Group

from flexhex.output.tables import Column, Row, table
from flexhex.simulation.faults import Fault, faults
from flexhex.ssp.result import Result
from flexhex.tracking import SETTLE, Tracking, tracking


def print_simulation(result: Result, path: Path) -> None:
    """Tracking, time spent in each FMU, faults and warnings, where the file is."""
    out = Console(highlight=False, soft_wrap=True)
    if tracked := tracking(result):
        out.print(tracking_text(tracked), markup=False)
    speed = result.duration / max(result.wall, 1e-9)
    out.print(
        f"\n{result.duration:g} s simulated in {result.wall:.2f} s, {speed:.1f} × real time",
        markup=False,
    )
    out.print(speed_table(result, "Time in each FMU"))
    print_faults(out, faults("the run", result))
    for name, spent in result.times.items():
        if spent.warnings:
            text = f"{name}: {spent.warnings} warnings, the first: {spent.warning}"
            out.print(f"warning: {text}", markup=False)
    out.print(f"result   {path}", markup=False)


def tracking_text(tracked: Tracking) -> str:
    """Tracking error and feedback torque in words."""
    lines = [
        f"Tracking from {tracked.begin:g} s to {tracked.end:g} s, all joints"
        + ("" if tracked.begin else f" (the run ends before {SETTLE:g} s: judged whole)"),
        f"  error e               RMS {tracked.e:.4g} µrad, largest {tracked.e_max:.4g} µrad"
        f" (joint {tracked.joint} at {tracked.at:.4f} s)",
    ]
    if math.isfinite(tracked.tau_fb):
        lines.append(f"  feedback torque τ_FB  RMS {tracked.tau_fb:.4g} N m")
    return "\n".join(lines)


def simulation_json(result: Result, path: Path) -> str:
    """The same for a program; units stand in the names, a figure that is no number is null."""
    data = {
        "result": str(path),
        "duration_s": result.duration,
        "wall_s": result.wall,
        "tracking": tracking_data(tracking(result)),
        "fmus": {
            name: {
                "steps": spent.steps,
                "total_s": spent.seconds,
                "worst_s": spent.worst,
                "warnings": spent.warnings,
            }
            for name, spent in result.times.items()
        },
        "faults": [asdict(fault) for fault in faults("the run", result)],
    }
    return json.dumps(data, indent=2, allow_nan=False)


def tracking_data(tracked: Tracking | None) -> dict[str, Any] | None:
    """Figures by names with their units."""
    if tracked is None:
        return None
    figures = {
        "from_s": tracked.begin,
        "to_s": tracked.end,
        "e_rms_urad": tracked.e,
        "e_max_urad": tracked.e_max,
        "e_max_joint": tracked.joint,
        "e_max_at_s": tracked.at,
        "tau_fb_rms_Nm": tracked.tau_fb,
    }
    return {key: value if math.isfinite(value) else None for key, value in figures.items()}


SPEED = (
    Column("fmu", "FMU"),
    Column("steps", "steps", "", "d"),
    Column("mean", "per step", "µs", ".2f"),
    Column("share", "per simulated second", "ms", ".2f"),
)


def speed_table(result: Result, title: str) -> Group:
    """Time spent in each FMU."""
    rows: list[Row] = [
        {
            "fmu": name,
            "steps": spent.steps,
            "mean": spent.seconds / max(spent.steps, 1) * 1e6,
            "share": spent.seconds / result.duration * 1e3,
        }
        for name, spent in result.times.items()
    ]
    return table(title, SPEED, rows)


def print_faults(out: Console, listed: Sequence[Fault]) -> None:
    """One line for each component that reported a fault: which, how often, since when."""
    for fault in listed:
        out.print(f"[red]fault[/] in {fault}; see fmus/*/README.md", highlight=False)

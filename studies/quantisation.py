"""What the drives' steps do to the tracking error of the adaptive loop, by simulation.

    python -m studies.quantisation [--duration S] [--json] [SSP ...]

tau* = tau_step round(tau / tau_step), theta* = theta_step round(theta / theta_step), the drives';
carried: feedback.fmu commands whole steps and adds what is left over to the next command.
"""

from __future__ import annotations

import argparse
import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.box import MARKDOWN
from rich.console import Console
from rich.table import Table

from flexhex.fmus.common.machine_file import read_toml
from flexhex.ssp.executor import run

Array = NDArray[np.float64]
CONFIGURATIONS = Path("gateway") / "machines"
SYSTEMS = (Path("out") / "hexapod.ssp", Path("out") / "machine" / "hexapod.ssp")
SETTLE = 2.0
"""Hold before the first move [s]: nothing is judged."""
DIGITS = (3, 2, 4)
CARRIED, LEFT = "remainder carried on", "remainder dropped"


@dataclass(frozen=True)
class Steps:
    """Torque [N m] and angle [rad] of one count; commanded: the torque step that feedback.fmu
    makes, 0: it leaves the rounding to the drive."""

    title: str
    tau: float
    commanded: float
    theta: float

    def parameters(self) -> dict[str, float]:
        """As start values of the simulation."""
        return {
            "plant.tau_step": self.tau,
            "feedback.tau_step": self.commanded,
            "plant.theta_step": self.theta,
        }


def torque_step(configuration: str) -> float:
    """Torque of one count [N m] of a configured drive: of its current, or of its rated torque."""
    scale = read_toml(CONFIGURATIONS / f"{configuration}.toml")["profile"]["scale"]
    if "current" in scale:
        current = scale["current"]
        return float(current["torque_constant_N_m_per_A"] * current["step_mA"] * 0.001)
    rated = scale["rated_torque"]
    return float(rated["rated_torque_N_m"] * rated["step_per_mille"] * 0.001)


def variants() -> tuple[Steps, ...]:
    """No steps, the encoder's alone, and each kind of drive with and without the rest."""
    theta = 2.0 * math.pi / 2.0**32
    listed = [Steps("no steps", 0.0, 0.0, 0.0), Steps("position 2^32 alone", 0.0, 0.0, theta)]
    for name, title in (("akd", "AKD, 1 mA"), ("cia402", "CiA 402, 0.1 %")):
        tau = torque_step(name)
        words = f"{title} = {1e3 * tau:g} mN m"
        listed.append(Steps(f"{words}, {CARRIED}", tau, tau, theta))
        listed.append(Steps(f"{words}, {LEFT}", tau, 0.0, theta))
    return tuple(listed)


def moved(ssp: Path, seconds: float, steps: Steps) -> tuple[Array, Array]:
    """Tracking error and angle after the hold (samples, 6) [rad]."""
    signals = ["feedback.e", "plant.theta"]
    result = run(
        ssp, SETTLE + seconds, signals=signals, parameters=steps.parameters(), timing=False
    )
    e, theta = (result[name][result.time(name) > SETTLE] for name in signals)
    return e, theta


def rms(values: Array) -> float:
    """Over samples and joints."""
    return float(np.sqrt(np.mean(values**2)))


def figures(ssp: Path, seconds: float) -> list[dict[str, Any]]:
    """For each variant: RMS and largest tracking error, RMS by which the angles moved from those of
    "no steps" [urad]."""
    rows: list[dict[str, Any]] = []
    exact: Array | None = None
    for steps in variants():
        e, theta = moved(ssp, seconds, steps)
        exact = theta if exact is None else exact
        values = {"rms": rms(e), "max": float(np.abs(e).max()), "change": rms(theta - exact)}
        rows.append({"title": steps.title} | {k: 1e6 * v for k, v in values.items()})
    return rows


def table(title: str, rows: list[dict[str, Any]]) -> Table:
    """A row for each variant."""
    out = Table(title=title, box=MARKDOWN)
    for name in ("steps", "e RMS [µrad]", "e max [µrad]", "change of θ RMS [µrad]"):
        out.add_column(name, justify="left" if name == "steps" else "right", no_wrap=True)
    for row in rows:
        figures = (row["rms"], row["max"], row["change"])
        shown = [f"{value:.{digits}f}" for value, digits in zip(figures, DIGITS, strict=True)]
        out.add_row(row["title"], *shown)
    return out


def main(arguments: list[str] | None = None) -> None:
    """Print a table for each system."""
    parser = argparse.ArgumentParser(prog="studies.quantisation", description=__doc__)
    parser.add_argument("systems", nargs="*", type=Path, default=SYSTEMS, metavar="SSP")
    parser.add_argument("--duration", type=float, default=20.0, help="time after the hold [s]")
    parser.add_argument("--json", action="store_true", help="print JSON instead of tables")
    options = parser.parse_args(arguments)
    seconds = options.duration
    measured = {str(ssp): figures(ssp, seconds) for ssp in options.systems}
    if options.json:
        print(json.dumps({"seconds": seconds, "systems": measured}))
        return
    for ssp, rows in measured.items():
        Console(width=120).print(table(f"{ssp}, {seconds:g} s after the hold", rows))


if __name__ == "__main__":
    main()

"""What `flexhex drive` shows: tables and verdicts, or JSON."""

from __future__ import annotations

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from flexhex.diagnose.words import verdict
from flexhex.drive.runs import Drives, error, errors, times


def data(found: Drives) -> dict[str, object]:
    """All figures, for a program."""
    return {
        "tracking error [urad]": {name: error(result) for name, result in found.results.items()},
        "cyclictest [us]": found.floor,
        "trips": {name: driven.trip for name, driven in found.driven.items() if driven.trip},
        "lockstep is the simulation": found.comparisons["lockstep"].equal,
        "largest difference": {n: worst(found, n) for n in found.comparisons},
        "diagnosis": {name: diagnosis.verdict for name, diagnosis in found.found.items()},
        "summary": {name: driven.summary for name, driven in found.driven.items()},
        "written": [str(path) for path in found.written],
    }


def worst(found: Drives, name: str) -> dict[str, float]:
    """Largest difference from the simulation by signal, each in its unit."""
    return {d.signal: d.worst for d in found.comparisons[name].differences}


def show(found: Drives) -> None:
    """Two tables, then what was compared and diagnosed."""
    out = Console(highlight=False, soft_wrap=True)
    out.print()
    out.print(table("Tracking error of the adaptive loop [µrad]", errors(found)))
    out.print(table("A cycle by the clock, 250 µs [µs]", times(found)))
    for name, good, text in judged(found):
        out.print(f"[{'green' if good else 'yellow'}]{'✓' if good else '!'}[/] {name}: {text}")
    if found.floor is None:
        out.print("! cyclictest is not installed: apt-get install rt-tests")
    for name, diagnosis in found.found.items():
        out.print(f"\n[bold]{name}.csv diagnosed[/]: {verdict(diagnosis)}")
        if np.isnan(diagnosis.gap.floor).all():
            out.print("  One run is little to go by: what does not repeat cannot be set apart.")
    folder = found.written[0].parent
    out.print(f"\n{folder}: clock.csv and lockstep.csv are the recordings. Look closer:")
    out.print(f"  flexhex diagnose {folder / 'clock.csv'}")
    out.print(f"  flexhex compare {folder / 'clock.h5'} {folder / 'simulated.h5'} --common")


def table(title: str, listed: list[dict[str, str]]) -> Table:
    """Rows under their title."""
    made = Table(title=title, title_justify="left", title_style="bold", box=SIMPLE_HEAD)
    for k, key in enumerate(listed[0]):
        made.add_column(key, justify="right" if k else "left")
    for row in listed:
        made.add_row(*row.values())
    return made


def judged(found: Drives) -> list[tuple[str, bool, str]]:
    """Each run: its name, whether all is well, what there is to say."""
    lockstep, clock = found.driven["lockstep"], found.driven["clock"]
    same = found.comparisons["lockstep"].equal
    words = "the simulation, every sample to the last bit" if same else "NOT the simulation"
    said = clock.summary
    cycles, skipped, lost = (int(said[key]) for key in ("cycles", "skipped", "lost"))
    apart = 1e6 * worst(found, "clock")["plant.theta"]
    times = (
        f"{cycles} cycles, {skipped} left out, {lost} frames without a reply in time;"
        f" angles at most {apart:.1f} µrad from the simulation"
    )
    slow = "; this computer is too busy for 4 kHz, see docs/gateway.md" if skipped + lost else ""
    listed = [("in lockstep", same, words), ("by the clock", not slow, times + slow)]
    trips = [("in lockstep", lockstep.trip), ("by the clock", clock.trip)]
    return listed + [(name, False, f"tripped: {trip}") for name, trip in trips if trip]

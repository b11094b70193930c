"""What `flexhex drive` shows: tables and verdicts, or JSON."""

from __future__ import annotations

import platform

import numpy as np
from rich.console import Console

from flexhex.diagnose.words import verdict
from flexhex.diagnosis.verdict import Diagnosis
from flexhex.drive.runs import LOCKSTEP, PASSES, SIMULATED, TITLES, Drives, error, errors, times
from flexhex.output.tables import table


def data(found: Drives) -> dict[str, object]:
    """All figures, for a program."""
    return {
        "tracking error [urad]": {name: error(result) for name, result in found.results.items()},
        "cyclictest [us]": found.floor,
        "trips": {name: driven.trip for name, driven in found.driven.items() if driven.trip},
        "lockstep is the simulation": found.comparisons[LOCKSTEP].equal,
        "largest difference": {n: worst(found, n) for n in found.comparisons},
        "diagnosis": found.found if isinstance(found.found, str) else found.found.data(),
        "summary": {name: driven.summary for name, driven in found.driven.items()},
        "written": [str(path) for path in found.written],
    }


def worst(found: Drives, name: str) -> dict[str, float]:
    """Largest difference from the simulation by signal, each in its unit."""
    return {d.signal: d.worst for d in found.comparisons[name].differences}


def show(found: Drives) -> None:
    """Two tables, then what was compared and diagnosed, and where to look closer."""
    out = Console(highlight=False, soft_wrap=True)
    out.print()
    out.print(table("Tracking error of the adaptive loop [µrad]", errors(found)))
    out.print(table("A cycle by the clock, of 250 µs: both passes [µs]", times(found)))
    for name, good, text in judged(found):
        out.print(f"[{'green' if good else 'yellow'}]{'✓' if good else '!'}[/] {name}: {text}")
    if found.floor is None:
        out.print("! cyclictest is not installed: apt-get install rt-tests")
    out.print(f"\n[bold]Both passes diagnosed[/]: {diagnosed(found.found)}")
    folder = found.written[0].parent
    first, second = (folder / f"{name}.csv" for name in PASSES)
    out.print("\nLook closer:")
    out.print(f"  flexhex report {first}")
    out.print(f"  flexhex diagnose {first} {second}")
    out.print(f"  flexhex compare {first} {folder / SIMULATED}.h5 --common --rtol 0.01")


def diagnosed(found: Diagnosis | str) -> str:
    """The verdict; of runs that are no pair no list of suspects."""
    if isinstance(found, str):
        return f"not possible: {found}."
    if found.verdict != "cannot tell" and np.isnan(found.gap.floor).all():
        return "nothing can be told: the two passes do not repeat each other."
    return verdict(found)


def judged(found: Drives) -> list[tuple[str, bool, str]]:
    """Each run: its name, whether all is well, what there is to say."""
    same = found.comparisons[LOCKSTEP].equal
    words = "the simulation, every sample to the last bit" if same else "NOT the simulation"
    listed = [(TITLES[LOCKSTEP], same, words), *(_by_the_clock(found, name) for name in PASSES)]
    if sum(_gaps(found, name) for name in PASSES):
        listed.append(("this computer", False, _computer()))
    trips = [(TITLES[name], driven.trip) for name, driven in found.driven.items()]
    return listed + [(name, False, f"tripped: {trip}") for name, trip in trips if trip]


def _gaps(found: Drives, name: str) -> int:
    return sum(int(found.driven[name].summary[key]) for key in ("skipped", "lost"))


def _by_the_clock(found: Drives, name: str) -> tuple[str, bool, str]:
    said = found.driven[name].summary
    text = (
        f"{said['cycles']} cycles, {said['skipped']} began too late and were left out,"
        f" {said['lost']} without a reply in time"
    )
    if name in found.comparisons:
        apart = 1e6 * worst(found, name)["plant.theta"]
        text += f"; angles at most {apart:.1f} µrad from the simulation"
    return TITLES[name], not _gaps(found, name), text


def _computer() -> str:
    """Why cycles were left out, as far as it is known here."""
    text = "is too busy for 4 kHz"
    if "PREEMPT_RT" not in platform.version():
        text += ", or its kernel keeps the cycle waiting: it is not PREEMPT_RT"
    return f"{text}; see docs/gateway.md"

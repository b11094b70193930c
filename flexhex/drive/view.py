"""What `flexhex drive` shows: tables and verdicts, or JSON."""

from __future__ import annotations

import platform

import numpy as np

from flexhex.diagnose.words import verdict
from flexhex.diagnosis.result.verdict import Diagnosis
from flexhex.drive.runs import (
    ERRORS,
    LOCKSTEP,
    PASSES,
    RELAXED,
    SIMULATED,
    TIMES,
    TITLES,
    Drives,
    error,
    errors,
    relaxed,
    times,
)
from flexhex.output.tables import console, table


def data(result: Drives) -> dict[str, object]:
    """All figures, for a program."""
    diagnosis = result.diagnosis
    return {
        "tracking error [urad]": {name: error(run) for name, run in result.results.items()},
        "cyclictest [us]": result.wake_up,
        "trips": {name: driven.trip for name, driven in result.driven.items() if driven.trip},
        "relaxed limits": relaxed(result.driven),
        "lockstep is the simulation": result.comparisons[LOCKSTEP].equal,
        "largest difference": {n: worst(result, n) for n in result.comparisons},
        "diagnosis": diagnosis if isinstance(diagnosis, str) else diagnosis.data(),
        "summary": {name: driven.summary for name, driven in result.driven.items()},
        "written": [str(path) for path in result.written],
    }


def worst(result: Drives, name: str) -> dict[str, float]:
    """Largest difference from the simulation by signal, each in its unit."""
    return {d.signal: d.worst for d in result.comparisons[name].differences}


def show(result: Drives) -> None:
    """Two tables, then what was compared and diagnosed, and where to look closer."""
    out = console()
    out.print()
    out.print(table("Tracking error of the adaptive loop", ERRORS, errors(result)))
    out.print(table("Times of a cycle by the clock, of 250 µs", TIMES, times(result)))
    for name, good, text in judged(result):
        out.print(f"[{'green' if good else 'yellow'}]{'✓' if good else '!'}[/] {name}: {text}")
    out.print(
        table("Limits that both passes by the clock did not have", RELAXED, relaxed(result.driven))
    )
    out.print("Emulated drives break nothing. On a machine the configured limits hold.\n")
    if result.wake_up is None:
        out.print("! cyclictest is not installed: apt-get install rt-tests")
    out.print(f"\n[bold]Both passes diagnosed[/]: {diagnosed(result.diagnosis)}")
    folder = result.written[0].parent
    first, second = (folder / f"{name}.csv" for name in PASSES)
    out.print("\nLook closer:")
    out.print(f"  flexhex report {first}")
    out.print(f"  flexhex diagnose {first} {second}")
    out.print(f"  flexhex compare {first} {folder / SIMULATED}.h5 --common --rtol 0.01")


def diagnosed(diagnosis: Diagnosis | str) -> str:
    """The verdict; of runs that are no pair no list of suspects."""
    if isinstance(diagnosis, str):
        return f"not possible: {diagnosis}."
    if diagnosis.verdict != "cannot tell" and np.isnan(diagnosis.residual.non_repeatable).all():
        return "no verdict: the two passes do not repeat each other."
    return verdict(diagnosis)


def judged(result: Drives) -> list[tuple[str, bool, str]]:
    """Each run: its name, whether all is well, what there is to say."""
    same = result.comparisons[LOCKSTEP].equal
    words = "the simulation, every sample to the last bit" if same else "NOT the simulation"
    listed = [(TITLES[LOCKSTEP], same, words), *(_by_the_clock(result, name) for name in PASSES)]
    if sum(_gaps(result, name) for name in PASSES):
        listed.append(("this computer", False, _computer()))
    trips = [(TITLES[name], driven.trip) for name, driven in result.driven.items()]
    return listed + [(name, False, f"tripped: {trip}") for name, trip in trips if trip]


def _gaps(result: Drives, name: str) -> int:
    return sum(int(result.driven[name].summary[key]) for key in ("skipped", "lost"))


def _by_the_clock(result: Drives, name: str) -> tuple[str, bool, str]:
    summary = result.driven[name].summary
    text = (
        f"{summary['cycles']} cycles, {summary['skipped']} began too late and were left out,"
        f" {summary['lost']} without a reply in time"
    )
    if name in result.comparisons:
        apart = 1e6 * worst(result, name)["plant.theta"]
        text += f"; angles at most {apart:.1f} µrad from the simulation"
    return TITLES[name], not _gaps(result, name), text


def _computer() -> str:
    """Why cycles were left out, as far as it is known here."""
    text = "is too busy for 4 kHz"
    if "PREEMPT_RT" not in platform.version():
        text += ", or its kernel keeps the cycle waiting: it is not PREEMPT_RT"
    return f"{text}; see docs/gateway-computer.md"

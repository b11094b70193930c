"""`flexhex report`: a recording of the gateway as a table and one offline page."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from flexhex.output.page import Part, write_page
from flexhex.output.plots import COLOURS, LOG, Figure, figure, multiples, trace
from flexhex.output.tables import Column, Row, console, table, texts
from flexhex.recording import Recording
from flexhex.report.recorded import (
    MICRO,
    PARTS,
    changes,
    errors,
    missed,
    quantiles,
    running,
    seconds,
    slower,
)
from flexhex.tracking import SETTLE

QUANTILES = ("p50", "p99", "p99.9", "largest")
COLOUR = COLOURS["adaptive"]


def data(found: Recording) -> dict[str, object]:
    """All figures, for a program."""
    return {
        "trip": found.meta.get("trip", ""),
        "duration_s": length(found),
        "missed": vars(missed(found)),
        "tracking_error_urad": [
            {"rms": rms, "largest": most, "at_s": at} for rms, most, at in errors(found)
        ],
        "times_us": {
            name: dict(zip(QUANTILES, values, strict=True))
            for name, values in quantiles(found).items()
        },
        "states": [{"at_s": t, "axes": axes, "state": text} for t, axes, text in changes(found)],
    }


def length(found: Recording) -> float:
    """Time that the controller ran in this file [s]."""
    time = seconds(found)[running(found)]
    return float(time[-1] - time[0] + found.base) if time.size else 0.0


def show(found: Recording, name: str, page: Path) -> None:
    """How it went, errors and times, where the page is."""
    out = console()
    out.print(f"[bold]{name}[/]")
    for what, text in summary(found):
        out.print(f"  {what:<20}", end="")
        out.print(text, markup=False)
    if running(found).any():
        out.print(table("Tracking error", ERRORS, _errors(found)))
        out.print(table("Times of a cycle", TIMES, _times(found)))
    out.print(f"page   {page}", markup=False)


ERRORS = (
    Column("axis", "axis"),
    Column("rms", "RMS", "µrad", ".2f"),
    Column("largest", "largest", "µrad", ".2f"),
    Column("at", "at", "s", ".3f"),
)
TIMES = (Column("part", ""), *(Column(name, name, "µs", ".1f") for name in QUANTILES))


def summary(found: Recording) -> list[tuple[str, str]]:
    """What a person wants to know first."""
    meta, gaps = found.meta, missed(found)
    trip = meta.get("trip", "")
    listed = [
        ("ended", f"tripped: {trip}" if trip else "without a trip"),
        ("time", f"{length(found):.2f} s, {found.base * 1e6:.0f} µs a cycle"),
        ("drives, system", f"{meta.get('drives', '?')}, {meta.get('system', '?')}"),
        ("cycles left out", f"{gaps.left_out}"),
        ("without a reply", f"{gaps.unanswered}"),
        ("incomplete replies", f"{gaps.short}"),
    ]
    if gaps.late_threads:
        listed.append(("late estimates", f"{gaps.late_threads}"))
    return listed


def write_recording(found: Recording, name: str, path: Path) -> Path:
    """The page of a recording."""
    parts = [Part("How it went", "", ("", ""), summary(found), words=True)]
    if running(found).any():
        parts += [_tracking(found), *_motion(found), _timing(found)]
    states = [(f"{t:.5f}", axes, text) for t, axes, text in changes(found)]
    words = "At the beginning, and whenever one changed."
    parts.append(Part("States", words, ("time [s]", "axes", "state"), states, words=True))
    return write_page(path, "A run on the drives", name, parts)


def _errors(found: Recording) -> list[Row]:
    return [
        {"axis": f"{axis}", "rms": rms, "largest": most, "at": at}
        for axis, (rms, most, at) in enumerate(errors(found), start=1)
    ]


def _times(found: Recording) -> list[Row]:
    return [
        {"part": PARTS[name], **dict(zip(QUANTILES, values, strict=True))}
        for name, values in quantiles(found).items()
    ]


def _drawn(found: Recording, channel: str, title: str, unit: str, scale: float = 1.0) -> Figure:
    """A panel for each axis of a channel; what was not measured is left out of the lines."""
    lines = {}
    for axis, column in enumerate(scale * found[channel].T, start=1):
        known, name = np.isfinite(column), f"axis {axis} [{unit}]"
        lines[name] = trace(seconds(found)[known], column[known], f"axis {axis}", COLOUR)
    return multiples(title, "time [s]", f"[{unit}]", lines, word="axis")


def _tracking(found: Recording) -> Part:
    drawn = {"error": _drawn(found, "e", "Tracking error", "µrad", MICRO)}
    text = f"Judged from {SETTLE:g} s on; a run that ends before is judged whole."
    return Part("Tracking error", text, *texts(ERRORS, _errors(found)), drawn, timed=True)


def _motion(found: Recording) -> list[Part]:
    """Panels have no title above them: each kind of them has a section."""
    listed = (("theta", "Angles, measured", "rad"), ("tau_meas", "Torques, measured", "N m"))
    return [
        Part(title, figures={name: _drawn(found, name, title, unit)}, timed=True)
        for name, title, unit in listed
    ]


def _timing(found: Recording) -> Part:
    rows, shares = running(found), []
    for name, title in PARTS.items():
        time, share = slower(found[name][rows])
        if time.size:
            shares.append(trace(time, share, title))
    drawn: dict[str, Figure] = {}
    if shares:
        title = "Share of cycles that took at least so long"
        drawn["share"] = figure(title, "time [µs]", "share", shares, xaxis=LOG, yaxis=LOG)
    text = (
        "A run in lockstep with the emulator has no wake-up: it waits for no clock, and its times"
        " are those of this computer."
    )
    return Part("Times of a cycle", text, *texts(TIMES, _times(found)), drawn)

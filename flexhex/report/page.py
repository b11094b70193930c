"""`flexhex report`: a recording of the gateway as a table and one offline page."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from flexhex.output.page import PageSection, write_page
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


def data(recording: Recording) -> dict[str, object]:
    """All figures, for a program."""
    return {
        "trip": recording.meta.get("trip", ""),
        "duration_s": length(recording),
        "missed": vars(missed(recording)),
        "tracking_error_urad": [
            {"rms": rms, "largest": most, "at_s": at} for rms, most, at in errors(recording)
        ],
        "times_us": {
            name: dict(zip(QUANTILES, values, strict=True))
            for name, values in quantiles(recording).items()
        },
        "states": [
            {"at_s": t, "axes": axes, "state": text} for t, axes, text in changes(recording)
        ],
    }


def length(recording: Recording) -> float:
    """Time that the controller ran in this file [s]."""
    time = seconds(recording)[running(recording)]
    return float(time[-1] - time[0] + recording.base) if time.size else 0.0


def show(recording: Recording, name: str, page: Path) -> None:
    """How it went, errors and times, where the page is."""
    out = console()
    out.print(f"[bold]{name}[/]")
    for what, text in summary(recording):
        out.print(f"  {what:<20}", end="")
        out.print(text, markup=False)
    if running(recording).any():
        out.print(table("Tracking error", ERRORS, _errors(recording)))
        out.print(table("Times of a cycle", TIMES, _times(recording)))
    out.print(f"page   {page}", markup=False)


ERRORS = (
    Column("axis", "axis"),
    Column("rms", "RMS", "µrad", ".2f"),
    Column("largest", "largest", "µrad", ".2f"),
    Column("at", "at", "s", ".3f"),
)
TIMES = (Column("part", ""), *(Column(name, name, "µs", ".1f") for name in QUANTILES))


def summary(recording: Recording) -> list[tuple[str, str]]:
    """What a person wants to know first."""
    meta, gaps = recording.meta, missed(recording)
    trip = meta.get("trip", "")
    listed = [
        ("ended", f"tripped: {trip}" if trip else "without a trip"),
        ("time", f"{length(recording):.2f} s, {recording.base * 1e6:.0f} µs a cycle"),
        ("drives, system", f"{meta.get('drives', '?')}, {meta.get('system', '?')}"),
        ("cycles left out", f"{gaps.left_out}"),
        ("without a reply", f"{gaps.unanswered}"),
        ("incomplete replies", f"{gaps.short}"),
    ]
    if gaps.late_threads:
        listed.append(("late estimates", f"{gaps.late_threads}"))
    return listed


def write_recording(recording: Recording, name: str, path: Path) -> Path:
    """The page of a recording."""
    parts = [PageSection("How it went", "", ("", ""), summary(recording), words=True)]
    if running(recording).any():
        parts += [_tracking(recording), *_motion(recording), _timing(recording)]
    states = [(f"{t:.5f}", axes, text) for t, axes, text in changes(recording)]
    words = "At the beginning, and whenever one changed."
    parts.append(PageSection("States", words, ("time [s]", "axes", "state"), states, words=True))
    return write_page(path, "A run on the drives", name, parts)


def _errors(recording: Recording) -> list[Row]:
    return [
        {"axis": f"{axis}", "rms": rms, "largest": most, "at": at}
        for axis, (rms, most, at) in enumerate(errors(recording), start=1)
    ]


def _times(recording: Recording) -> list[Row]:
    return [
        {"part": PARTS[name], **dict(zip(QUANTILES, values, strict=True))}
        for name, values in quantiles(recording).items()
    ]


def _drawn(recording: Recording, channel: str, title: str, unit: str, scale: float = 1.0) -> Figure:
    """A panel for each axis of a channel; what was not measured is left out of the lines."""
    lines = {}
    for axis, column in enumerate(scale * recording[channel].T, start=1):
        known, name = np.isfinite(column), f"axis {axis} [{unit}]"
        lines[name] = trace(seconds(recording)[known], column[known], f"axis {axis}", COLOUR)
    return multiples(title, "time [s]", f"[{unit}]", lines, word="axis")


def _tracking(recording: Recording) -> PageSection:
    drawn = {"error": _drawn(recording, "e", "Tracking error", "µrad", MICRO)}
    text = f"Judged from {SETTLE:g} s on; a run that ends before is judged whole."
    return PageSection(
        "Tracking error", text, *texts(ERRORS, _errors(recording)), drawn, timed=True
    )


def _motion(recording: Recording) -> list[PageSection]:
    """Panels have no title above them: each kind of them has a section."""
    listed = (("theta", "Angles, measured", "rad"), ("tau_meas", "Torques, measured", "N m"))
    return [
        PageSection(title, figures={name: _drawn(recording, name, title, unit)}, timed=True)
        for name, title, unit in listed
    ]


def _timing(recording: Recording) -> PageSection:
    rows, shares = running(recording), []
    for name, title in PARTS.items():
        time, share = slower(recording[name][rows])
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
    return PageSection("Times of a cycle", text, *texts(TIMES, _times(recording)), drawn)

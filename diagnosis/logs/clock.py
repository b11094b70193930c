"""Time columns onto even clocks: gaps, resets, jitter, rounding, drift between columns.

t_k = t0 + k ts        k counts sample periods, also those that were not recorded
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from math import erfc, sqrt

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.logs.between import FEWEST, between
from flexhex.diagnosis.logs.log import Array, Channel, Finding
from flexhex.fmus.common.errors import LogError

Index = NDArray[np.int64]
RESETS = 3
"""More backward jumps than this are no clock that was set anew."""
LONGEST_FILL = 0.5
"""Longest gap [s] that is filled; a longer one becomes a break."""
QUIET_JITTER = 2e-3
"""Jitter, relative to the period, that is not worth a word."""
MOST_JITTER = 0.3
"""Beyond it a sample's place on an even clock is a guess."""
AROUND = 9
"""Samples on either side of a long step that tell whether one is missing there."""


@dataclass(frozen=True)
class Clock:
    """Where the rows of a table stand on an even clock.

    keep: rows of the table that are used; place (kept,): their sample numbers, None when row k
    is sample k; size: number of samples; breaks: as in Channel; jitter: RMS, relative to ts.
    stamps (kept,) [s]: times of the rows where these are uneven and true, see `stamps`.
    """

    t0: float
    ts: float
    keep: slice | Index
    place: Index | None
    size: int
    breaks: tuple[tuple[int, float], ...] = ()
    jitter: float = 0.0
    findings: tuple[Finding, ...] = field(default=())
    stamps: Array | None = None

    def channel(self, values: Array) -> Channel:
        """The kept rows of values (rows, width) on this clock; samples between are invalid."""
        kept = values[self.keep]
        if self.stamps is not None:
            return between(self.stamps, kept, self.t0, self.ts, self.size)
        if self.place is None:
            return Channel(self.t0, self.ts, kept, np.ones(len(kept), dtype=bool), self.breaks)
        valid = np.zeros(self.size, dtype=bool)
        valid[self.place] = True
        filled = np.full((self.size, kept.shape[1]), np.nan)
        filled[self.place] = kept
        return Channel(self.t0, self.ts, filled, valid, self.breaks)


def clock_of(where: str, time: Array, joins: tuple[int, ...] = ()) -> Clock:
    """The even clock of a time column (samples,) [s].

    joins: rows that do not follow the row before. Raises LogError for a time that runs
    backwards, stands still, or is so uneven that samples cannot be placed.
    """
    notes: list[Finding] = []
    keep, joins = _finite(where, time, joins, notes)
    keep, joins = _forward(where, time, keep, joins, notes)
    t = time[keep]
    if len(t) < FEWEST:
        raise LogError(f"{where}: {len(t)} samples are too few, at least {FEWEST} are needed")
    steps = np.diff(t)
    follows = np.ones(len(steps), dtype=bool)
    follows[[j - 1 for j in joins]] = False
    if (steps[follows] == 0).mean() > 0.2:
        return _rounded(where, t, keep, joins, notes)
    if (steps == 0).any():
        doubles = np.flatnonzero((steps == 0) & follows) + 1
        text = f"{len(doubles)} samples repeat the time before them and are left out"
        notes.append(Finding("duplicate", where, text, True))
        rows = np.arange(len(time))[keep]
        return clock_merged(clock_of(where, np.delete(t, doubles)), np.delete(rows, doubles), notes)
    return _even(where, t, keep, steps, follows, notes)


def clock_merged(inner: Clock, rows: Index, notes: list[Finding]) -> Clock:
    """A clock found on some rows of a table, said in rows of the whole table."""
    return replace(inner, keep=rows[inner.keep], findings=(*notes, *inner.findings))


def _finite(
    where: str, time: Array, joins: tuple[int, ...], notes: list[Finding]
) -> tuple[slice | Index, tuple[int, ...]]:
    """Rows with a time; blanks at the end belong to a slower column and are no finding."""
    good = np.isfinite(time)
    if good.all():
        return slice(0, len(time)), joins
    rows = np.flatnonzero(good)
    if not len(rows):
        raise LogError(f"{where}: time holds no number")
    last = int(rows[-1]) + 1
    if len(rows) == last:
        return slice(0, last), tuple(j for j in joins if j < last)
    if not joins:
        count = last - len(rows)
        notes.append(Finding("nan", where, f"{count} rows without a time are left out", True))
    moved = {int(np.searchsorted(rows, j)) for j in joins}
    return rows, tuple(sorted(j for j in moved if 0 < j < len(rows)))


def _forward(
    where: str,
    time: Array,
    keep: slice | Index,
    joins: tuple[int, ...],
    notes: list[Finding],
) -> tuple[slice | Index, tuple[int, ...]]:
    """The longest stretch without a clock reset. LogError when time runs backwards at will."""
    t = time[keep]
    back = np.flatnonzero(np.diff(t) < 0) + 1
    if not len(back):
        return keep, joins
    edges = np.array([0, *back, len(t)])
    longest = int(np.argmax(np.diff(edges)))
    begin, end = int(edges[longest]), int(edges[longest + 1])
    if len(back) > RESETS or end - begin < FEWEST:
        k = int(back[0])
        raise LogError(
            f"{where}: time runs backwards {len(back)} times, first from {t[k - 1]:.6g} s to"
            f" {t[k]:.6g} s in sample {k + 1}: sort the rows or export the run again"
        )
    text = (
        f"the clock was set back {len(back)} times (first in sample {back[0] + 1}); of"
        f" {len(t)} samples the longest stretch of {end - begin} is used"
    )
    notes.append(Finding("reset", where, text, False))
    rows = np.arange(len(time))[keep][begin:end]
    return rows, tuple(j - begin for j in joins if begin < j < end)


def _rounded(
    where: str, t: Array, keep: slice | Index, joins: tuple[int, ...], notes: list[Finding]
) -> Clock:
    """Time written with fewer digits than its period: rows are counted instead."""
    steps = np.diff(t)
    if not (steps > 0).any():
        raise LogError(f"{where}: time stands still at {t[0]:.6g} s")
    resolution = float(steps[steps > 0].min())
    slope, start = np.polyfit(np.arange(len(t)), t, 1)
    apart = float(np.abs(t - (start + slope * np.arange(len(t)))).max())
    if joins or apart > 1.5 * resolution:
        raise LogError(
            f"{where}: time is written in steps of {resolution:.3g} s, coarser than its samples,"
            " and some are missing: export it with more digits"
        )
    text = f"time is written in steps of {resolution:.3g} s: taken as even, {slope:.6g} s a sample"
    notes.append(Finding("jitter", where, text, True))
    return Clock(float(start), float(slope), keep, None, len(t), findings=tuple(notes))


def _even(
    where: str,
    t: Array,
    keep: slice | Index,
    steps: Array,
    follows: NDArray[np.bool_],
    notes: list[Finding],
) -> Clock:
    """Place samples by whole periods between neighbours; long gaps become breaks."""
    ts = float(np.median(steps[follows]))
    normal = follows & (steps < 1.5 * ts)
    ts = float(steps[normal].mean())
    uneven = np.abs(steps[normal] / ts - 1)
    rms = float(np.sqrt((uneven**2).mean()))
    # of stamps that jitter some steps are half a period off, of others many
    far = max(0.01, 2 * erfc(0.5 / max(rms, 1e-9) / sqrt(2)))
    if rms > MOST_JITTER * sqrt(2) or (uneven > 0.5).mean() > far:
        k = int(np.argmax(np.where(normal, np.abs(steps - ts), 0)))
        raise LogError(
            f"{where}: time is not evenly spaced: {steps[k]:.6g} s after sample {k + 1},"
            f" {ts:.6g} s elsewhere: interpolate all channels to even times if they were taken at"
            " these, else give each sample the time of its cycle"
        )
    long = ~follows | (steps > LONGEST_FILL + ts)
    count = np.maximum(np.rint(steps / ts), 1).astype(np.int64)
    if (uneven > 0.25).any() and not long.any():
        count = _missing(steps / ts, count)
    missed = (count > 1) & ~long
    count[long] = 2  # one invalid sample stands for what is skipped
    jitter = rms / sqrt(2)
    if missed.any():
        lost = int((count[missed] - 1).sum())
        k = int(np.argmax(missed))
        text = f"{lost} samples were dropped in {missed.sum()} gaps, the first at {t[k]:.6g} s"
        notes.append(Finding("gap", where, text + ": bridged by straight lines, not used", True))
    gaps = np.flatnonzero(long & follows)
    if len(gaps):
        k = int(gaps[0])
        text = f"{len(gaps)} long gaps, the first of {steps[k]:.4g} s at {t[k]:.6g} s: cut there"
        notes.append(Finding("break", where, text, True))
    place = np.concatenate([[0], np.cumsum(count)])
    cuts = np.flatnonzero(long)
    breaks = tuple((int(place[k + 1]), float(steps[k] - 2 * ts)) for k in cuts)
    whole = int(place[-1]) + 1
    t0 = float(t[0])
    if not len(cuts):
        slope, t0 = (float(v) for v in np.polynomial.polynomial.polyfit(place, t, 1)[::-1])
        ts = slope if abs(slope - ts) > 1e-9 * ts else ts
        t0 = float(t[0]) if abs(t0 - t[0]) < 1e-6 * ts else t0
    if jitter > QUIET_JITTER:
        text = f"time jitters by {jitter * ts:.2g} s RMS around {ts:.6g} s: taken as even"
        notes.append(Finding("jitter", where, text, False))
    sparse = None if whole == len(t) else place
    return Clock(t0, ts, keep, sparse, whole, breaks, jitter, tuple(notes))


def _missing(steps: Array, count: Index) -> Index:
    """Periods between neighbours where samples around say that none is missing: these would all be
    a period early.

    steps: in periods.
    """
    count = count.copy()
    early = np.concatenate([[0.0], np.cumsum(steps - count)])
    for k in np.flatnonzero(count == 2):
        before, after = early[max(k + 1 - AROUND, 0) : k + 1], early[k + 1 : k + 1 + AROUND]
        if np.median(after) - np.median(before) < -0.5:
            count[k] = 1
            early[k + 1 :] += 1.0
    return count

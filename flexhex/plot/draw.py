"""What `plot` shows: a row with a small curve for each scalar, and the plots of a page."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from flexhex.fmus.common.errors import UsageError
from flexhex.fmus.common.interface import indices
from flexhex.output.page import PageSection, write_page
from flexhex.output.plots import Figure, figure, multiples, scaled, trace
from flexhex.output.tables import Column, Row, console, table
from flexhex.ssp.result import Array, Result
from flexhex.view.thin import rows

WIDTH = 40
"""Characters of a small curve."""
LEVELS = "▁▂▃▄▅▆▇█"
INK = "#1f6fb2"
"""Colour of a line that has a panel of its own."""


@dataclass(frozen=True)
class Picked:
    """A signal over the shown time: time (n,) [s], values (n, columns), names, unit of each."""

    name: str
    time: Array
    values: Array
    columns: tuple[str, ...]
    units: tuple[str, ...]


def chosen(result: Result, signals: Sequence[str], span: tuple[float, float]) -> list[Picked]:
    """The signals in that time. LogError for an unknown one, UsageError where it has no sample."""
    picked = []
    for signal in signals:
        group = result.group(signal)
        array = group.array(signal)
        first, end = rows(group, *span)
        if first >= end:
            raise UsageError(
                f"--from {span[0]:g} --to {span[1]:g}: {signal} lasts from 0 to"
                f" {group.time[-1]:g} s"
            )
        every = group.columns(array)
        names = every if signal == array else [signal]
        places = [every.index(name) for name in names]
        values = group.signals[array].reshape(group.rows, -1)[first:end, places]
        units = tuple(group.column_units(array)[place] for place in places)
        picked.append(Picked(signal, group.time[first:end], values, tuple(names), units))
    return picked


def curve(values: Array, width: int = WIDTH) -> str:
    """A mark for each of `width` stretches, on a scale from lowest to highest sample: of the sample
    that is farthest from the mean of all, so that what swings is seen.

    Blank where a stretch holds no number.
    """
    parts = [part[np.isfinite(part)] for part in np.array_split(values, min(width, len(values)))]
    known = values[np.isfinite(values)]
    if not known.size:
        return " " * len(parts)
    low, height, middle = known.min(), np.ptp(known), known.mean()
    far = [part[np.abs(part - middle).argmax()] if part.size else low for part in parts]
    shares = [(value - low) / height if height else 0.0 for value in far]
    marks = [LEVELS[min(int(share * len(LEVELS)), len(LEVELS) - 1)] for share in shares]
    return "".join(mark if part.size else " " for mark, part in zip(marks, parts, strict=True))


COLUMNS = (
    Column("name", "signal"),
    Column("curve", "over time"),
    Column("low", "lowest", "", ".4g"),
    Column("high", "highest", "", ".4g"),
    Column("rms", "RMS", "", ".4g"),
    Column("unit", "unit"),
)


def overview(picked: Sequence[Picked]) -> None:
    """The table of all scalars."""
    listed: list[Row] = []
    for one in picked:
        for name, unit, values in zip(one.columns, *prefixed(one), strict=True):
            known = values[np.isfinite(values)]
            figures = (known.min(), known.max(), np.sqrt(np.mean(known**2))) if known.size else ()
            low, high, rms = figures or (np.nan,) * 3
            listed.append(
                {
                    "name": name,
                    "curve": curve(values),
                    "low": float(low),
                    "high": float(high),
                    "rms": float(rms),
                    "unit": unit,
                }
            )
    times = [one.time for one in picked]
    begin, end = min(t[0] for t in times), max(t[-1] for t in times)
    console().print(table(f"{begin:g} s to {end:g} s", COLUMNS, listed))


def listing(result: Result) -> None:
    """All signals of a run by rate."""
    out = console()
    for group in result.groups.values():
        out.print(f"every {group.Ts * 1e3:g} ms, {group.rows} samples", markup=False)
        for name in group.signals:
            columns = group.columns(name)
            size = f"{len(columns)} × " if len(columns) > 1 else ""
            out.print(f"  {name:<24} {size}{group.units.get(name, '')[:24]}", markup=False)


def prefixed(one: Picked) -> tuple[list[str], list[Array]]:
    """Units and values of the elements, with one prefix for all where they have one unit."""
    if len(set(one.units)) == 1:
        values, unit = scaled(one.values, one.units[0])
        return [unit] * len(one.units), list(values.T)
    pairs = [scaled(v, unit) for v, unit in zip(one.values.T, one.units, strict=True)]
    return [unit for _, unit in pairs], [values for values, _ in pairs]


def drawn(one: Picked) -> Figure:
    """A plot of a scalar; of an array a panel for each element."""
    return _panels(one) if len(one.columns) > 1 else _alone(one)


def _alone(one: Picked) -> Figure:
    values, unit = scaled(one.values[:, 0], one.units[0])
    lines = [trace(one.time, values, one.name)]
    return figure("", "time [s]", _label(one.name, unit), lines, margin={"t": 15, "r": 15})


def _panels(one: Picked) -> Figure:
    """Elements that are counted are those of joints, others have names."""
    short = [column.removeprefix(one.name) for column in one.columns]
    counted = short == list(indices(len(short)))
    names = [f"joint {i}" if counted else text.strip(".[]") for i, text in enumerate(short, 1)]
    alike = len(set(one.units)) == 1
    units, columns = prefixed(one)
    panels = {
        _label(name, unit): trace(one.time, column, full, INK)
        for name, unit, column, full in zip(names, units, columns, one.columns, strict=True)
    }
    label = _label(one.name, units[0] if alike else "")
    return multiples(one.name, "time [s]", label, panels, numbered=counted, alike=alike)


def _label(name: str, unit: str) -> str:
    return f"{name} [{unit}]" if unit not in ("", "1") else name


def write_plots(picked: Sequence[Picked], name: str, path: Path) -> Path:
    """The page: a plot for each signal, a panel for each joint, on linked time axes."""
    parts = []
    for k, one in enumerate(picked):
        parts.append(PageSection(one.name, figures={f"signal{k}": drawn(one)}, timed=True))
    return write_page(path, "Signals of a run", name, parts)

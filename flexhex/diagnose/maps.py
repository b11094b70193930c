"""Figures of where the residual is: over angle, velocity, acceleration, torque, time, frequency.

The page shows one axis at a time, that of its selector.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import groupby
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnose.plots import AFTER, BEFORE, MARGIN, TOP
from flexhex.diagnosis.result.pictured import Map
from flexhex.output.plots import (
    LOG,
    Figure,
    broken,
    figure,
    gaps,
    of_joint,
    per_joint,
    rounded,
    trace,
)

Array = NDArray[np.float64]
FREQUENCY = "frequency"
"""What a map is over that is a spectrum."""
MARKED = 60
"""Bins of a map up to which each has a large mark."""
SHORT = 50.0
"""Range of a logarithmic axis up to which powers of ten alone would be one label or two."""
SHADE = "rgba(209,115,29,0.18)"
SMALL = {"height": 290, "margin": {**MARGIN, "t": 60, "l": 70}, "legend": TOP}


def map_figures(maps: Sequence[Map], first: int) -> dict[str, Figure]:
    """A figure for each quantity, of all axes whose maps have its units; first: the axis (from 1)
    that the page begins with."""
    drawn = {}
    for k, ((over, unit, residual), same) in enumerate(_alike(maps, spectra=False)):
        lines = [of_joint(m.axis, line) for m in same for line in _residual(m)]
        title = f"over {over}, axis {{joint}}"
        one = figure(
            title, f"{over} [{unit}]", f"residual [{residual}]", lines, xaxis={"nticks": 6}, **SMALL
        )
        drawn[f"map-{k}"] = per_joint(one, "axis", first)
    return drawn


def spectrum_figures(maps: Sequence[Map], first: int) -> dict[str, Figure]:
    """The residual over frequency, both axes logarithmic, otherwise as `map_figures`."""
    drawn = {}
    for k, ((over, unit, residual), same) in enumerate(_alike(maps, spectra=True)):
        lines = [
            of_joint(m.axis, trace(m.centre, values, name, colour))
            for m in same
            for values, name, colour in ((m.before, "before", BEFORE), (m.after, "after", AFTER))
        ]
        y = {"type": "log", "exponentformat": "power", "dtick": _dtick(lines)}
        logs: dict[str, Any] = {"xaxis": LOG, "yaxis": y}
        title = "over frequency, axis {joint}"
        one = figure(
            title, f"{over} [{unit}]", f"residual [{residual}/√Hz]", lines, **logs, **SMALL
        )
        drawn[f"spectrum-{k}"] = per_joint(one, "axis", first)
    return drawn


def _dtick(lines: Sequence[dict[str, Any]]) -> int | str:
    """Labels of a logarithmic axis: powers of ten, and 2 and 5 between them where it is short."""
    values = np.array([v for line in lines for v in line["y"] if v])
    return 1 if len(values) and values.max() > SHORT * values.min() else "D2"


def _alike(
    maps: Iterable[Map], spectra: bool
) -> Iterable[tuple[tuple[str, str, str], Sequence[Map]]]:
    """Maps of one quantity in one unit, in the order in which they come first."""

    def key(m: Map) -> tuple[str, str, str]:
        return m.over, m.unit, m.residual

    chosen = [m for m in maps if (m.over == FREQUENCY) == spectra]
    places = list(dict.fromkeys(key(m) for m in chosen))
    ordered = sorted(chosen, key=lambda m: places.index(key(m)))
    return [(name, list(same)) for name, same in groupby(ordered, key)]


def _residual(m: Map) -> list[dict[str, Any]]:
    """Means before, with a band of two standard errors, and after; none over bins without data."""
    size = 4 if len(m.centre) <= MARKED else 2
    marker: dict[str, Any] = {"mode": "lines+markers", "marker": {"size": size}}
    return [
        _band(m.centre, m.before - 2 * m.spread, m.before + 2 * m.spread),
        trace(*broken(m.centre, m.before), "before", BEFORE, **marker),
        trace(*broken(m.centre, m.after), "after", AFTER, **marker),
    ]


def _band(x: Array, low: Array, high: Array) -> dict[str, Any]:
    """A shade between two lines, in pieces where bins are missing."""
    pieces = [
        (np.r_[x[k], x[k][::-1], np.nan], np.r_[low[k], high[k][::-1], np.nan])
        for k in np.split(np.arange(len(x)), gaps(x))
    ]
    xs, ys = (np.concatenate(parts) for parts in zip(*pieces, strict=True))
    quiet = {"showlegend": False, "hoverinfo": "skip", "mode": "lines", "line": {"width": 0}}
    around = {"x": rounded(xs), "y": rounded(ys), "fill": "toself", "fillcolor": SHADE}
    return {**around, **quiet, "name": "band", "meta": {"joins": True}}

"""Figures of the report as plotly data: plain dictionaries, no plotting library at run time."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexhex.output.tables import printed

Array = NDArray[np.float64]
Figure = dict[str, Any]
COLOURS = {"feedback": "#8c8c8c", "fixed": "#d1731d", "adaptive": "#1f6fb2"}
MAX_POINTS = 3000
ALIKE = 0.1
"""Height of a line, relative to that of all, below which it would look flat beside them."""
APART = {"ticks": "outside", "ticklen": 4, "tickcolor": "rgba(0,0,0,0)"}
"""Labels of an axis do not touch what is drawn."""
WIDE = 1.5
"""Steps of the usual width from which on samples are missing between two."""
PREFIXES = ((1e-3, "m"), (1e-6, "µ"), (1e-9, "n"))
PREFIXED = ("rad", "m", "N m", "N", "s", "rad/s", "m/s", "A", "V")
"""Units that may have a prefix."""
_TICKS = [f"{digit}e{power}" for power in range(-9, 10) for digit in (1, 2, 5)]
LOG: dict[str, Any] = {
    "type": "log",
    "tickvals": [float(tick) for tick in _TICKS],
    "ticktext": [f"{float(tick):g}" for tick in _TICKS],
}
"""Axis with whole labels at 1, 2, 5 of every decade: plots that span one or two of them."""


def thinned(t: Array, y: Array, points: int = MAX_POINTS) -> tuple[Array, Array]:
    """At most `points` samples that keep the extremes of every stretch."""
    bins = len(t) // (points // 2)
    if bins < 2:
        return t, y
    n = len(t) // bins
    block = y[: n * bins].reshape(n, bins)
    first = np.arange(n) * bins
    picked = np.sort(np.concatenate([first + block.argmin(axis=1), first + block.argmax(axis=1)]))
    return t[picked], y[picked]


def trace(
    t: Array,
    y: Array,
    name: str,
    colour: str | None = None,
    points: int = MAX_POINTS,
    **more: Any,
) -> dict[str, Any]:
    """One line, thinned to at most `points` and rounded to six digits; NaN in y is a gap."""
    t, y = thinned(np.asarray(t), np.asarray(y), points)
    line = {"width": 1.2} | ({"color": colour} if colour else {})
    xs = [float(f"{v:.6g}") for v in t]
    return {"x": xs, "y": rounded(y), "name": name, "mode": "lines", "line": line} | more


def rounded(values: Array) -> list[float | None]:
    """Five digits; a figure that is no number leaves a gap."""
    return [float(f"{v:.5g}") if math.isfinite(v) else None for v in values]


def scaled(values: Array, unit: str) -> tuple[Array, str]:
    """Values with the prefix that fits the largest of them: 23e-6 rad are 23 µrad."""
    known = np.abs(values[np.isfinite(values)])
    most = known.max() if known.size else 0.0
    if unit not in PREFIXED or not 0 < most < 1:
        return values, unit
    size, prefix = next(((s, p) for s, p in PREFIXES if most >= s), PREFIXES[-1])
    return values / size, prefix + unit


def gaps(x: Array) -> NDArray[np.intp]:
    """Places in rising x before which a sample is missing: its step is WIDE times the usual one."""
    steps = np.diff(x)
    return np.flatnonzero(steps > WIDE * np.median(steps)) + 1 if len(steps) else np.zeros(0, int)


def broken(x: Array, y: Array) -> tuple[Array, Array]:
    """x and y with a NaN in y where samples are missing, so that no line bridges them."""
    at = gaps(x)
    return np.insert(x, at, (x[at - 1] + x[at]) / 2), np.insert(y, at, np.nan)


def figure(
    title: str, x: str, y: str, traces: Sequence[Mapping[str, Any]], **layout: Any
) -> Figure:
    """A figure with axis titles; layout is merged over the house style.

    The scheme's colours are added where it is drawn (frame/frame.js). Lines over a common x show
    their values together; `{joint}` in the title is the chosen joint.
    """
    x, y = printed(x), printed(y)
    together = all("lines" in one.get("mode", "") for one in traces)
    base: dict[str, Any] = {
        "title": {"text": title, "font": {"size": 15}, "x": 0, "xref": "paper"},
        "xaxis": {"title": {"text": x}, "zeroline": False},
        "yaxis": {"title": {"text": y}, "zeroline": False} | APART,
        "margin": {"l": 85, "r": 215, "t": 45, "b": 50},
        "height": 360,
        "hovermode": "x unified" if together else "closest",
        "font": {"family": "system-ui, sans-serif", "size": 13},
    }
    for key, value in layout.items():
        base[key] = base[key] | value if isinstance(base.get(key), dict) else value
    return {"data": list(traces), "layout": base}


def of_joint(number: int, line: dict[str, Any]) -> dict[str, Any]:
    """A line that is seen when the page's selector stands on this joint (from 1)."""
    return line | {"meta": {**line.get("meta", {}), "joint": number}, "visible": number == 1}


def per_joint(figure: Figure, word: str = "joint", first: int = 1) -> Figure:
    """A figure of lines made by `of_joint`. word: what the selector calls them; first: the one that
    the page begins with."""
    layout = figure["layout"]
    return {**figure, "layout": {**layout, "meta": {"joint": word, "first": first}}}


def multiples(
    title: str,
    x: str,
    y: str,
    panels: Mapping[str, Mapping[str, Any]],
    word: str = "joint",
    numbered: bool = True,
    alike: bool = True,
) -> Figure:
    """A figure with a panel for each line, by the name that stands over it.

    word: what the page's selector calls them; numbered: it chooses among these, too; alike: all
    have one unit. Those have one scale to begin with, unless the smallest line would be less than
    ALIKE of it.
    """
    lines, axes = list[dict[str, Any]](), dict[str, Any]()
    for k, line in enumerate(panels.values()):
        number = str(k + 1) if k else ""
        place = {"panel": k} | ({"joint": k + 1} if numbered else {})
        lines.append({**line, "xaxis": f"x{number}", "yaxis": f"y{number}", "meta": place})
        axes[f"xaxis{number}"] = {"title": {"text": x}, "zeroline": False}
        axes[f"yaxis{number}"] = {"title": {"text": y}, "zeroline": False}
    # no number among those of a line: it has no height
    known = [[v for v in line["y"] if v is not None and math.isfinite(v)] for line in lines]
    heights = [max(values) - min(values) if values else 0.0 for values in known]
    every = [v for values in known for v in values] or [0.0]
    same = min(heights) >= ALIKE * (max(every) - min(every)) if alike else None
    meta = {"joint": word, "first": 0, "multiples": {"names": list(panels), "same": same}}
    return figure(title, x, y, lines, **axes, meta=meta)


def spectrum(e: Array, ts: float) -> tuple[Array, Array]:
    """Frequency [Hz] and amplitude density of a signal (samples, n), RMS over the columns."""
    from scipy.signal import welch

    f, power = welch(e, 1 / ts, nperseg=min(len(e), 16384), axis=0)
    return f[1:], np.sqrt(power.mean(axis=1))[1:]


def moving_rms(e: Array, ts: float, width: float = 0.25) -> Array:
    """RMS over the columns in a Hann window of `width` [s].  [SH, Fig. 4]"""
    from scipy.signal import oaconvolve

    window = np.hanning(max(3, round(width / ts)))
    power = np.mean(np.square(e), axis=1)
    smooth = oaconvolve(power, window / window.sum(), mode="same")
    return np.asarray(np.sqrt(np.maximum(smooth, 0.0)))

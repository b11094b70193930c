"""The page of a comparison: tracking of both runs, overlays and differences, all figures."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from flexhex.compare.results import EQUAL, OUT, UNLIKE, Array, Comparison, Difference
from flexhex.compare.runs import Figures, Run
from flexhex.compare.view import (
    HEADINGS,
    cells,
    figure_headings,
    figure_rows,
    judged_text,
    missing,
    verdict,
)
from flexhex.output.page import PageSection, write_page
from flexhex.output.plots import Figure, figure, moving_rms, scaled, trace
from flexhex.tracking import ERROR, MICRO, columns

DIFFERENCE, LIMIT = "#444", "#c33"
NARROW = {"height": 280}


def write_comparison(
    comparison: Comparison, judged: Figures | None, runs: Sequence[Run], plots: int, path: Path
) -> Path:
    """Tracking, overlay and difference of the `plots` signals that differ most, all signals."""
    chosen = [d for d in comparison.of(OUT, EQUAL) if d.worst > 0][:plots]
    parts = [_tracking(judged, runs)] if judged else []
    title = verdict(comparison)
    parts.append(
        PageSection(title[0].upper() + title[1:], text=" · ".join(missing(comparison, runs)))
    )
    for k, d in enumerate(chosen):
        overlay, difference = _plots(d, runs)
        drawn = {f"overlay{k}": overlay, f"difference{k}": difference}
        parts.append(PageSection(cells(d)[0], text=_sentence(d), figures=drawn, timed=True))
    if not chosen:
        parts.append(PageSection("No plots", text="No signal differs at all."))
    rows = [cells(d) for d in comparison.of(OUT, UNLIKE, EQUAL)]
    parts.append(PageSection("All signals", headings=HEADINGS, rows=rows))
    provenance = [(key, *pair) for key, pair in comparison.provenance.items()]
    text = "" if provenance else "Nothing: the same versions, hashes and parameters."
    headings = ("", *(run.name for run in runs))
    parts.append(
        PageSection("How the runs were made: differences", text, headings, provenance, words=True)
    )
    files = " and ".join(f"{run.name} ({run.file})" for run in runs)
    return write_page(path, "Two runs compared", files, parts)


def _tracking(judged: Figures, runs: Sequence[Run]) -> PageSection:
    """The figures, and the moving RMS of the tracking error of both runs."""
    lines = []
    for run in runs:
        group = run.result.group(ERROR)
        rms = moving_rms(columns(run.result[ERROR]), group.Ts) * MICRO
        shown = (group.time >= judged.begin) & (group.time <= judged.end)
        lines.append(trace(group.time[shown], rms[shown], run.name, run.colour))
    title = "Tracking error, RMS over all joints in a moving window of 0.25 s"
    drawn = {"tracking": figure(title, "time [s]", "e [µrad]", lines)}
    return PageSection(
        "Tracking", judged_text(judged), figure_headings(runs), figure_rows(judged), drawn, True
    )


def _plots(d: Difference, runs: Sequence[Run]) -> tuple[Figure, Figure]:
    """The worst element of a signal in both runs, and second minus first with its tolerance."""
    (t, x), (s, y) = (_element(d, run) for run in runs)
    n = min(len(x), len(y))
    name, si = cells(d)[0], cells(d)[3]
    both, unit = scaled(np.concatenate([x, y]), si)
    pairs = ((t, both[: len(x)]), (s, both[len(x) :]))
    lines = [trace(*pair, run.name, run.colour) for pair, run in zip(pairs, runs, strict=True)]
    overlay = figure(name, "time [s]", f"[{unit}]", lines, **NARROW)
    with np.errstate(invalid="ignore"):
        apart, unit = scaled(np.append(y[:n] - x[:n], d.limit), si)
    apart, limit = apart[:-1], apart[-1]
    lines = [trace(t[:n], apart, "difference", DIFFERENCE)]
    # a tolerance that cannot be told from the axis would only add two lines to it
    if d.limit > 0.01 * d.worst:
        for sign, label in ((1, "tolerance"), (-1, "")):
            ends = np.array([t[0], t[n - 1]])
            lines.append(
                trace(ends, np.full(2, sign * limit), label, LIMIT, showlegend=bool(label))
            )
    title = f"{name}: {runs[1].name} minus {runs[0].name}"
    return overlay, figure(title, "time [s]", f"difference [{unit}]", lines, **NARROW)


def _element(d: Difference, run: Run) -> tuple[Array, Array]:
    result = run.result
    return result.time(d.signal), columns(result[d.signal])[:, max(d.element, 1) - 1]


def _sentence(d: Difference) -> str:
    row = dict(zip(HEADINGS, cells(d), strict=True))
    unit, since = row["unit"], row["out from [s]"]
    late = f", out of tolerance from {since} s on" if since else ""
    return (
        f"Largest difference {row['worst']} {unit} at {row['at [s]']} s ({row['relative']} of the"
        f" largest value, allowed {row['allowed']} {unit}), RMS {row['RMS']} {unit}{late}."
    )

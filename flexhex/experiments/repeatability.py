"""Repeatability, [SH, V-A case 4]: what the passes of one trajectory do not have in common.

The figures are those of Table I (`flexhex.simulation.passes`); here the passes are shown one over
the other, and the table shows what the factor sqrt(n / (n - 1)) does. The mean of n passes
contains a share of every pass, so deviations from it come out too small by sqrt((n - 1) / n).
With the factor, 1.22 for three passes, the figure does not depend on n: it says by how much a
single pass leaves what is repeatable. The paper does not say whether its figures have it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from flexhex.diagnosis.estimation.identify import Fit
from flexhex.fmus.common.machine.machine import Machine
from flexhex.output.plots import COLOURS, LOG, Figure, figure, moving_rms, trace
from flexhex.output.progress import Progress
from flexhex.output.tables import Column
from flexhex.simulation.builder import Builder
from flexhex.simulation.cases import table_cases, whole_moves
from flexhex.simulation.metrics import Figures, figure_columns
from flexhex.simulation.metrics import figures as judged
from flexhex.simulation.passes import PASSES, repeatability_figures, repeatable_share, repeated_case
from flexhex.simulation.published import Published, published, published_row
from flexhex.simulation.runs import Array, record, samples, variant
from flexhex.ssp.results import Result

SIGNALS = ("plant.theta", "feedback.e", "feedback.tau_fb")
COLUMNS = (Column("title", "RMS"), *figure_columns(2, 5))
SHOWN = 4.0
"""Time of the passes that is drawn one over the other [s]."""
COLOUR, SHADES = "#3a8f4d", ("#d1731d", "#8a4fae", "#1a93a5")


@dataclass(frozen=True)
class Repeatability:
    """Figures of three passes, and what the plots need.

    fixed: over all passes; apart: non-repeatable part, with the factor sqrt(n / (n - 1));
    plain: without it; adaptive: one pass with adaptive feedforward, what the share is of.
    e, deviation (passes, samples, n) [rad], deviation without factor; e_adaptive (samples, n).
    published: figures of the machine itself, if there are any.
    """

    passes: int
    fixed: Figures
    apart: Figures
    plain: Figures
    adaptive: Figures
    t: Array
    e: Array
    deviation: Array
    e_adaptive: Array
    published: Published | None = None

    @property
    def factor(self) -> float:
        """sqrt(n / (n - 1)) for n passes."""
        return unbiased(self.passes)

    @property
    def repeatable_share(self) -> float:
        """Share of the remaining feedback torque that is repeatable, a ratio of RMS values."""
        return repeatable_share(self.apart, self.adaptive)

    @property
    def repeatable_share_plain(self) -> float:
        """The same without the factor."""
        return repeatable_share(self.plain, self.adaptive)

    @property
    def repeatable_share_of_power(self) -> float:
        """The same as a share of the mean square."""
        return 1 - (self.apart.tau_fb / self.adaptive.tau_fb) ** 2


def unbiased(passes: int) -> float:
    """Factor on the RMS deviation from the mean of `passes` equally long passes."""
    return math.sqrt(passes / (passes - 1))


def by_pass(signal: Array, passes: int) -> Array:
    """(passes, samples, n) of a signal that starts with the first pass; a rest is left out."""
    length = len(signal) // passes
    return np.asarray(signal[: passes * length].reshape(passes, length, -1))


def deviations(values: Array) -> Array:
    """What each pass (passes, samples, n) differs from the mean of all passes."""
    return np.asarray(values - values.mean(axis=0))


def run(builder: Builder, fit: Fit, progress: Progress, command: str, quick: bool) -> Repeatability:
    """Three passes with fixed feedforward, one with adaptive feedforward beside them."""
    machine = builder.machine
    seconds = whole_moves(machine, 6.0) if quick else machine.reference.duration
    repeated = repeated_case(machine, fit.p, seconds)
    adaptive = table_cases(machine, fit.p, seconds, fit.std)[-1]
    cases = (
        variant(repeated, "passes", "three passes", repeated.duration, {}),
        variant(adaptive, "passes-adaptive", "adaptive beside it", adaptive.duration, {}),
    )
    results = record(builder, cases, SIGNALS, command, progress)
    return evaluate(machine, results, published(builder.machine_file))


def evaluate(
    machine: Machine, results: Sequence[Result], known: Published | None = None
) -> Repeatability:
    """Figures from two results: three passes with fixed, one pass with adaptive feedforward."""
    repeated, single = results
    t, e, _ = samples(repeated, "feedback.e")
    theta, tau = (samples(repeated, name)[1] for name in ("plant.theta", "feedback.tau_fb"))
    alone = [samples(single, name)[1] for name in SIGNALS]
    passes = by_pass(e, PASSES)
    apart, length = repeatability_figures(machine, repeated), passes.shape[1]
    plain = Figures(*(value / unbiased(PASSES) for value in apart.row()))
    return Repeatability(
        PASSES,
        judged(machine, theta, e, tau),
        apart,
        plain,
        judged(machine, *alone),
        t[:length],
        passes,
        deviations(passes),
        alone[1][:length],
        known,
    )


def rows(result: Repeatability) -> list[dict[str, Any]]:
    """The rows of the table: title, figures by name; the published row of its kind, if any."""
    listed: list[dict[str, Any]] = [
        {"title": title} | asdict(figures)
        for title, figures in (
            ("fixed feedforward, all passes", result.fixed),
            ("not repeatable", result.apart),
            ("not repeatable, without √(n/(n−1))", result.plain),
        )
    ]
    if result.published and "repeatability" in result.published.rows:
        listed.append(published_row(result.published.rows["repeatability"]))
    return listed


def figures(result: Repeatability) -> dict[str, Figure]:
    """Error against time, in all and its non-repeatable part; passes one over the other."""
    return {"repeatability-error": _error(result), "repeatability-passes": _passes(result)}


def _error(result: Repeatability) -> Figure:
    t, ts = result.t, float(result.t[1] - result.t[0])

    def over_passes(values: Array) -> Array:
        power = np.mean([moving_rms(one, ts) ** 2 for one in values], axis=0)
        return np.asarray(1e6 * np.sqrt(power))

    lines = [
        trace(t, over_passes(result.e), "fixed", COLOURS["fixed"]),
        trace(t, over_passes(result.e_adaptive[None]), "adaptive", COLOURS["adaptive"]),
        trace(t, result.factor * over_passes(result.deviation), "not repeatable", COLOUR),
    ]
    title = "Error and its non-repeatable part, RMS over joints and passes in a 0.25 s window"
    return figure(title, "time in a pass [s]", "e [µrad]", lines, yaxis=LOG)


def _passes(result: Repeatability) -> Figure:
    keep = result.t < SHOWN
    t, lines = result.t[keep], []
    for k in range(result.passes):
        shade, group = SHADES[k % len(SHADES)], dict[str, Any](legendgroup=str(k))
        e, apart = (1e6 * values[k, keep, 0] for values in (result.e, result.deviation))
        lines.append(trace(t, e, f"pass {k + 1}", shade, **group))
        name = f"pass {k + 1} − mean"
        lines.append(trace(t, apart, name, shade, yaxis="y2", showlegend=False, **group))
    title = "Error of joint 1 in each pass; below, its deviation from the mean of the passes"
    lower = {"domain": [0, 0.27], "title": {"text": "deviation [µrad]"}}
    upper = {"domain": [0.35, 1]}
    anchor = {"anchor": "y2"}
    return figure(
        title,
        "time in a pass [s]",
        "e [µrad]",
        lines,
        xaxis=anchor,
        yaxis=upper,
        yaxis2=lower | {"zeroline": False},
        height=420,
    )

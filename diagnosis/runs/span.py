"""Which part of a run has rows, and what is said of one that is too short for them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Base
from flexhex.diagnosis.runs.run import Run
from flexhex.fmus.common.errors import LogError

Array = NDArray[np.float64]
MOST = 8_000
"""Instants of all runs together; more are thinned to these, so that an hour takes no more memory
than a minute."""
LATEST = 3.0
"""Largest delay of the torques, in tolerances."""
JUDGED = 50
"""Fewest rows of a run that say anything."""
CUT = 4
"""Samples of a log at whose place a run has no rates, two at each end."""


def refuse_short(base: Base, runs: Sequence[Run], option: str = "") -> None:
    """LogError when a run is too short for any fit, before anything is said of it; option: what
    says how much of its start is left out."""
    spacing = spacing_for(base, runs)
    for passes in by_trajectory(runs):
        instants(base, passes, spacing, option=option)


def by_trajectory(runs: Sequence[Run]) -> list[list[Run]]:
    """The passes of each trajectory."""
    names = dict.fromkeys(run.trajectory for run in runs)
    return [[run for run in runs if run.trajectory == name] for name in names]


def spacing_for(base: Base, runs: Sequence[Run]) -> float:
    """Time between rows [s]: the base's own, or more where that makes too many instants."""
    total = sum(max(0.0, b - a) for a, b in (_span(base, run) for run in runs))
    return max(base.spacing, total / MOST)


def instants(
    base: Base, passes: Sequence[Run], spacing: float, least: int = JUDGED, option: str = ""
) -> Array:
    """Instants (m,) that the passes of a trajectory share [s]. LogError where they are fewer than
    `least` at the base's own spacing."""
    spans = [_span(base, run) for run in passes]
    first, last = max(a for a, _ in spans), min(b for _, b in spans)
    k = np.arange(int(np.ceil(first / spacing)), int(np.floor(last / spacing)) + 1)
    if len(k) * spacing < least * base.spacing:
        raise LogError(_too_short(base, passes, last - first, least * base.spacing, option))
    return np.asarray(k * spacing)


def _too_short(
    base: Base, passes: Sequence[Run], remains: float, needed: float, option: str
) -> str:
    """How long the runs are, what is taken off, and what is needed."""
    lengths = [(len(run.valid) + CUT) * run.motion.ts for run in passes]
    if len(passes) == 1:
        head, what = f"{passes[0].name}: {lengths[0]:.3g} s are too short", ""
    else:
        listed = " and ".join(f"{r.name} ({s:.3g} s)" for r, s in zip(passes, lengths, strict=True))
        head, what = f"{listed}, passes of one motion, share too little of it", " in common"
    given = f" ({option} {base.settle:g})" if option else ""
    settle = f"the first {base.settle:g} s{given} are left out, " if base.settle else ""
    ends = max(2 * _margin(base, run) + CUT * run.motion.ts for run in passes)
    doubt = ": is the unit of its times right?" if max(lengths) < needed else ""
    return (
        f"{head}: {settle}smoothing takes {ends:.2g} s at the ends, {max(0.0, remains):.2g} s"
        f" remain{what}; at least {needed:.3g} s are needed{doubt}"
    )


def _span(base: Base, run: Run) -> tuple[float, float]:
    """What can be used of a run, in the time that its passes share [s]."""
    clocks = [(run.motion.t0, run.motion.ts, len(run.valid))]
    clocks.append((run.tau.t0, run.tau.ts, len(run.tau.valid)))
    start = max(t0 for t0, _, _ in clocks)
    end = min(t0 + ts * (count - 1) for t0, ts, count in clocks)
    margin = _margin(base, run)
    return start + base.settle + margin - run.shift, end - margin - run.shift


def _margin(base: Base, run: Run) -> float:
    """What smoothing takes at each end of a run [s]."""
    return max(base.window, base.window / 2 + LATEST * base.late * run.tau.ts)

"""Between commanded and reported torque: the drives, searched like the mechanism."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from flexhex.diagnosis.drives.late import DELAY, LAG, Late, LateBench, bends, lag_or_delay
from flexhex.diagnosis.drives.path import PathBase, driven
from flexhex.diagnosis.hypotheses.candidates import Bench
from flexhex.diagnosis.hypotheses.compiled import compiled
from flexhex.diagnosis.jointfit.fit import calibrate
from flexhex.diagnosis.kinds import kinds_of
from flexhex.diagnosis.regression.calibrate import Calibrated
from flexhex.diagnosis.runs.blocks import blocks
from flexhex.diagnosis.runs.run import Run
from flexhex.diagnosis.selection.found import found
from flexhex.diagnosis.selection.side import Side
from flexhex.fmus.common.effects import library

APART = 3.0
"""Standard deviations by which an axis must lag behind the quicker ones to be set apart."""
NOTICED = 0.5
"""Smallest effect of a drive, relative to one that is worth noticing: a lag of 0.1 ms."""
STEPS = 6
"""Steps to a common lag."""
WHERE = "between commanded and reported torque: "


def drives_of(model: Calibrated, runs: Sequence[Run], judged: Sequence[Run]) -> list[Side]:
    """What the drives do to a command, where logs have both; model: as the mechanism was fitted.

    Lag and delay are one column. Where they can be told apart, the search begins anew with the
    exact form of what is late, so that only what that leaves is asked about.
    """
    if not driven(runs, 0.0):
        return []
    base = model.base
    path = PathBase(
        model.torque_rms, base.window, model.spacing, base.settle, kinds_of(base, base.n)
    )
    common = common_lag(path, runs)
    there = calibrate(path, blocks(path, driven(runs, common), path.spacing))
    drives = compiled(base.n, {name: e for name, e in library().items() if e.reported})
    validation = driven(judged, common)
    side = found(Bench(there, drives), validation, lambda text: None).side
    late = _late(side, path, runs, common)
    if late:
        refined = LateBench(there, drives, late)
        side = found(refined, validation, lambda text: None).side
        texts = dict.fromkeys(each.text for each in late.values())
        side = replace(side, notes=(*side.notes, *texts))
    return [replace(side, notes=tuple(WHERE + note for note in side.notes))]


def _late(side: Side, path: PathBase, runs: Sequence[Run], common: float) -> dict[int, Late]:
    """Axes (from 0) whose drives are late in a way that could be late: all alike, or else those
    of each effect that was found."""
    known = [effect for effect in side.fit.effects if effect.id in (LAG, DELAY)]
    if not known:
        return {}
    estimates = enumerate(bends(path, driven(runs, common), range(path.n)))
    least = NOTICED * library()[LAG].gains[0].typical
    times = {i: b.late for i, b in estimates if b.late > max(least, APART * b.late_deviation)}
    late = lag_or_delay(path, runs, common, times, list(times)) if times else {}
    for axes in [] if late else [[i for i in effect.axes if i in times] for effect in known]:
        if axes:
            late |= lag_or_delay(path, runs, common, times, axes)
    return late


def common_lag(path: PathBase, runs: Sequence[Run]) -> float:
    """Time [s] by which the drives' reports lag behind the commands, on the quickest axes.

    The current loop and the logger make it; an axis that lags more has an effect, and several
    may. 0 where no command moves. A lag of many samples is approached in steps: only a short one
    makes a derivative of the command.
    """
    lag, sample = 0.0, max(run.tau.ts for run in runs)
    for _ in range(STEPS):
        listed = bends(path, driven(runs, lag), range(path.n))
        determined = [b for b in listed if b.late_deviation < np.inf]
        step = quickest([b.late for b in determined], [b.late_deviation**2 for b in determined])
        lag += step
        if abs(step) < sample:
            break
    return lag


def quickest(lags: Sequence[float], variances: Sequence[float]) -> float:
    """Weighted mean of the shortest lags: of all that noise alone may set apart from those below.

    The shortest of several equal lags is short by chance, and would make the others seem late.
    """
    order = np.argsort(lags)
    total = weight = 0.0
    for i in order:
        if weight and lags[i] - total / weight > APART * np.sqrt(variances[i] + 1.0 / weight):
            break
        total, weight = total + lags[i] / variances[i], weight + 1.0 / variances[i]
    return total / weight if weight else 0.0

"""Which effects a planned experiment can tell apart, as data."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.bases import base_of
from flexhex.diagnosis.hypotheses.candidates import Bench
from flexhex.diagnosis.hypotheses.compiled import compiled
from flexhex.diagnosis.kinds import kinds_of, refuse_others
from flexhex.diagnosis.logs import Log
from flexhex.diagnosis.planning.trajectory import Trajectory, read_trajectory
from flexhex.diagnosis.regression.calibrate import Calibrated
from flexhex.diagnosis.regression.fitted import Fitted
from flexhex.diagnosis.regression.gram import ABSORBED
from flexhex.diagnosis.regression.linearize import about
from flexhex.diagnosis.regression.regression import Columns, Regression
from flexhex.diagnosis.runs.blocks import blocks
from flexhex.diagnosis.runs.differences import motion_of
from flexhex.diagnosis.runs.noise import Noise
from flexhex.diagnosis.runs.run import Run, TimeSeries
from flexhex.diagnosis.runs.runs import FASTEST
from flexhex.fmus.common.errors import LogError

if TYPE_CHECKING:
    from flexhex.diagnosis.basemodels.base import Base, Known
    from flexhex.diagnosis.prepare import Options

Array = NDArray[np.float64]
NOISE = 0.005
"""Noise of a smoothed torque that is assumed before anything was measured [N m, N]."""
CLEAR = 100.0
"""Fall of the sum of squares, in units of the noise, from which on an effect is found."""
ALIKE = 0.9
"""Share from which on two effects count as one that cannot be told apart."""


@dataclass(frozen=True)
class Isolability:
    """Effects by id and the axis they were tried on (from 1, empty: the whole machine).

    share (k, k): how much of one effect the other can take over, 1 = cannot be told apart, on the
    diagonal 1; smallest (k,) [unit]: torque RMS from which on an effect is found, NaN: never;
    axis: the one that the effects were tried on, of n (from 1).
    """

    effects: tuple[str, ...]
    axes: tuple[tuple[int, ...], ...]
    share: Array
    smallest: Array
    unit: str = "N m"
    axis: int = 1
    n: int = 1

    def rivals(self, k: int, alike: float = ALIKE) -> list[int]:
        """Effects that cannot be told from effect k, the most alike first."""
        row = np.fmax(self.share[k], self.share[:, k])
        rivals = [j for j in np.argsort(-row, kind="stable") if j != k and row[j] >= alike]
        return [int(j) for j in rivals]

    def data(self) -> dict[str, Any]:
        """As in `--json`; a figure that is no number is null."""
        smallest = [float(v) if math.isfinite(v) else None for v in self.smallest]
        return {
            "effects": list(self.effects),
            "axes": [list(axes) for axes in self.axes],
            "share": [[float(v) if math.isfinite(v) else None for v in row] for row in self.share],
            "smallest": {"unit": self.unit, "values": smallest},
        }


def isolability(
    paths: Sequence[Path],
    machine_file: Path | None,
    options: Options,
    progress: Callable[[str, int, int], None],
) -> Isolability:
    """What runs along trajectories could show, at the nominal model and an assumed noise.

    All effects are put on the axis that moves most. LogError for trajectories that cannot be
    read or are too short.
    """
    progress("reading", 0, 3)
    planned = [read_trajectory(path, options.log) for path in paths]
    first = planned[0]
    log = Log.of(first.name, first.ts, first.r, np.zeros_like(first.r), first.kinds)
    base = base_of(options.base, machine_file, log, options.tolerance, options.joints)
    for t, path in zip(planned, paths, strict=True):
        if t.r.shape[1] != base.n:
            raise LogError(f"{path}: {t.r.shape[1]} axes, the model has {base.n}")
        refuse_others(str(path), t.kinds, kinds_of(base, base.n), "the base model")
    model = _planned(base, planned)
    progress("effects along the trajectories", 1, 3)
    axis = int(np.argmax(np.std(np.concatenate([t.r for t in planned]), axis=0)))
    bench = Bench(model, compiled(base.n, without=base.holds))
    names = [*bench.names(axis), *bench.whole]  # one axis alone has no coupling
    share, smallest = np.eye(len(names)), np.full(len(names), np.nan)
    for j, truth in enumerate(names):
        progress(truth, 1, 3)
        columns, torque = _example(bench, truth, axis)
        seen = _as_data(model.regression, columns)
        falls = np.array([_best(bench, seen, name, axis) for name in names])
        if falls[j] <= ABSORBED * float((columns.values**2).sum()):
            continue  # the base model takes it up whole
        share[j] = np.clip(falls / falls[j], 0.0, 1.0)
        smallest[j] = torque * np.sqrt(CLEAR / falls[j])
    progress("done", 3, 3)
    places = tuple((axis + 1,) if name in bench.effects else () for name in names)
    unit = bench.scales.kinds[axis].unit("N m")
    return Isolability(tuple(names), places, share, smallest, unit, axis + 1, base.n)


def _planned(base: Base, planned: Sequence[Trajectory]) -> Calibrated:
    """The nominal model along the trajectories, without any data."""
    p, gains, widths = (
        np.array([_supposed(known) for known in listed])
        for listed in (base.linear, base.curved, base.widths)
    )
    runs = []
    for k, t in enumerate(planned):
        step = max(1, round(FASTEST / t.ts))
        r = t.r[::step]
        whole = np.ones(len(r), dtype=bool)
        motion = motion_of(TimeSeries(0.0, step * t.ts, r, whole), None)
        tau = TimeSeries(motion.t0, motion.ts, base.torque(motion, p), whole[2:-2])
        runs.append(Run(t.name, f"{t.name} {k}", motion, whole[2:-2], tau))
    n = base.n
    noise = Noise.even(n, NOISE)
    listed = blocks(base, runs, base.spacing)
    late = base.late * listed[0].run.tau.ts
    return about(base, listed, Fitted(p, gains, widths, 0.0, late), noise)


def _supposed(known: Known) -> float:
    """The nominal value; one of its unit where nothing is known, lest there be no torque at all."""
    return known.nominal if np.isfinite(known.tolerance) else 1.0


def _example(bench: Bench, name: str, axis: int) -> tuple[Columns, float]:
    """Columns of an effect of typical shape and size, one column, and its torque RMS [N m]."""
    item = bench.effects.get(name)
    shape = {}
    if item:
        shape = bench.scales.sized(name, axis, {s.name: s.start for s in item.effect.shapes})
    if "source" in shape:
        shape["source"] = float((axis + 1) % bench.n + 1)
    columns = bench.columns(name, axis, shape)
    gains = np.array([g.typical for g in item.effect.gains]) if item else np.full(2, 0.01)
    values = columns.values[:, : len(gains)] @ gains[:, None]
    return Columns(columns.axis, values), float(np.sqrt((values**2).mean())) * NOISE


def _as_data(regression: Regression, columns: Columns) -> Regression:
    """The regression with an effect as its only data."""
    y = np.zeros(len(regression.y))
    y[regression.layout.rows(columns.axis)] = columns.values[:, 0]
    right = regression.pulled(regression.layout.across(y), None)
    return replace(regression, y=y, known=(regression.gram[0], right))


def _best(bench: Bench, seen: Regression, name: str, axis: int) -> float:
    """Largest fall of the sum of squares by an effect of any shape of its grid."""
    grid = bench.grid(name, axis)
    first = grid[0][1]
    stacked = np.hstack([columns.values for _, columns in grid])
    return float(seen.falls(first.axis, stacked, first.values.shape[1]).max())

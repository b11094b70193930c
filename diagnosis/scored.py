"""One effect on one axis: its best shape, and what it brings beside the base model's columns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.candidates import Bench
from flexhex.diagnosis.regression import Columns, Gain, Regression
from flexhex.fmus.common.effects import Shape

Array = NDArray[np.float64]
PROMISING = 25.0
"""Fall of the sum of squares below which a candidate is not looked at any further."""
CONTENDER = 0.4
"""Candidates with less than this share of the best fall on their axis are left at that."""
GIVE_UP = 3
"""Candidates in a row that may explain nothing outside their own trajectory."""
REFINE, STARTS = 3, 3
"""Halvings of the grid's distances, from so many points of it."""
AS_WELL, STARTS_AGAIN = 0.97, 6
"""Share of the best fall at which another point of the grid does as well; how many are asked."""


@dataclass(frozen=True)
class Scored:
    """An effect on one axis (None: on the whole): its best shape, what it brings, its columns.

    still: places of gains that are held at zero, their columns are zero: the best possible value.
    """

    id: str
    axis: int | None
    shape: dict[str, float]
    gain: Gain
    columns: Columns
    still: tuple[int, ...] = ()

    def moved(self, bench: Bench, shape: dict[str, float]) -> Scored:
        """With the columns of another shape, or along other runs."""
        columns = bench.columns(self.id, self.axis or 0, shape)
        return replace(self, shape=shape, columns=_without(columns, self.still))


@dataclass(frozen=True)
class Found:
    """An effect with the axes on which it was found, and the effects that do nearly as well."""

    id: str
    parts: tuple[Scored, ...]
    rivals: tuple[str, ...]

    @property
    def axes(self) -> tuple[int, ...]:
        """Axes from 0; nothing where it acts on the whole."""
        return tuple(part.axis for part in self.parts if part.axis is not None)

    @property
    def outside(self) -> float:
        """What it gains on trajectories left out, all axes."""
        return sum(part.gain.outside for part in self.parts)


def leaders(bench: Bench, regression: Regression, axis: int | None) -> list[Scored]:
    """Effects on an axis (None: on the whole) that come near the best one there."""
    names, at = bench.names(axis), axis or 0
    falls = {name: _falls(bench, regression, name, at) for name in names}
    best, found = 0.0, list[Scored]()
    for name, values in sorted(falls.items(), key=lambda item: -float(item[1].max())):
        # what falls where fitted alone sets no measure: many shapes fit chance
        if values.max() < max(PROMISING, CONTENDER * best):
            break
        if best <= 0 and len(found) == GIVE_UP:
            break
        part = _scored(bench, regression, (name, axis), values)
        best = max(best, part.gain.outside)
        found.append(part)
    return found


def scored(bench: Bench, regression: Regression, name: str, axis: int | None) -> Scored:
    """An effect on an axis (None: on the whole) with its best shape."""
    return _scored(bench, regression, (name, axis), _falls(bench, regression, name, axis or 0))


def _falls(bench: Bench, regression: Regression, name: str, axis: int) -> Array:
    """What each shape of an effect's grid explains where it is fitted."""
    grid = bench.grid(name, axis)
    first = grid[0][1]
    stacked = np.hstack([columns.values for _, columns in grid])
    return regression.falls(first.axis, stacked, first.values.shape[1])


def _scored(
    bench: Bench, regression: Regression, place: tuple[str, int | None], falls: Array
) -> Scored:
    """An effect on an axis with its best shape, or with one of the grid that does as well and
    whose gains are possible, or with impossible ones held at zero."""
    name, axis = place
    shape, columns = _refined(bench, regression, name, axis or 0, falls)
    best = Scored(name, axis, shape, regression.gain(columns), columns)
    if allowed(bench, best):
        return best
    grid = bench.grid(name, axis or 0)
    for k in np.argsort(-falls)[:STARTS_AGAIN]:
        if falls[k] < AS_WELL * falls.max():
            break
        shape, columns = grid[k]
        other = Scored(name, axis, shape, regression.gain(columns), columns)
        if allowed(bench, other):
            return other
    return _held(bench, regression, best)


def _held(bench: Bench, regression: Regression, best: Scored) -> Scored:
    """An effect with those gains at zero that would have to be negative, if others are left.

    Without its further gains an effect that extends another is that one, which is asked by itself.
    """
    item = bench.effects.get(best.id)
    if item is None or item.effect.extends:
        return best
    pairs = zip(item.effect.gains, best.gain.beta, strict=True)
    still = tuple(k for k, (gain, beta) in enumerate(pairs) if beta < gain.low == 0)
    free = [k for k in range(len(item.effect.gains)) if k not in still]
    if not still or not free:
        return best
    grid = bench.grid(best.id, best.axis or 0)
    stacked = np.hstack([columns.values[:, free] for _, columns in grid])
    falls = regression.falls(grid[0][1].axis, stacked, len(free))
    found = replace(best, still=still).moved(bench, grid[int(np.argmax(falls))][0])
    return replace(found, gain=regression.gain(found.columns))


def _without(columns: Columns, still: Sequence[int]) -> Columns:
    """Columns with some of them zero."""
    if not still:
        return columns
    values = columns.values.copy()
    values[:, list(still)] = 0.0
    return Columns(columns.axis, values)


def allowed(bench: Bench, scored: Scored) -> bool:
    """Whether the gains may have these signs and sizes: no friction pushes."""
    deviation = np.sqrt(np.maximum(np.diag(scored.gain.covariance), 0.0))
    return possible(bench, (scored.id, scored.axis), scored.gain.beta, deviation)


def possible(bench: Bench, place: tuple[str, int | None], beta: Array, deviation: Array) -> bool:
    """Whether gains of an effect on an axis are within its bounds, or may be: two deviations."""
    name, axis = place
    if name not in bench.effects:
        return True
    values = zip(bench.scales.bounds(name, axis or 0), beta, 2 * deviation, strict=True)
    return all(low - s <= value <= high + s for (low, high), value, s in values)


def _refined(
    bench: Bench, regression: Regression, name: str, axis: int, falls: Array
) -> tuple[dict[str, float], Columns]:
    """The best shape near the grid: searched from the best point for each of the last shape.

    A sharp maximum may hide beside a blunt one of the grid: a mode that rings for long is missed
    by all but its neighbours.
    """
    grid = bench.grid(name, axis)
    searched = bench.searched(name, axis)
    if not searched:
        return grid[int(np.argmax(falls))]
    groups: dict[float, int] = {}
    for k, (shape, _) in enumerate(grid):
        value = shape[searched[-1].name] if len(searched) > 1 else 0.0
        if value not in groups or falls[k] > falls[groups[value]]:
            groups[value] = k
    starts = sorted(groups.values(), key=lambda k: -falls[k])[:STARTS]
    best = [
        _climbed(bench, regression, (name, axis), searched, (*grid[k], float(falls[k])))
        for k in starts
    ]
    shape, columns, _ = max(best, key=lambda found: found[2])
    return shape, columns


def _climbed(
    bench: Bench,
    regression: Regression,
    place: tuple[str, int],
    searched: Sequence[Shape],
    start: tuple[dict[str, float], Columns, float],
) -> tuple[dict[str, float], Columns, float]:
    """Uphill from a point of the grid, with half the distance to its neighbours each time."""
    shape, columns, fall = start
    tried = [other for other, _ in bench.grid(*place)]
    steps = {
        s.name: sorted({abs(other[s.name] - shape[s.name]) for other in tried})[1] for s in searched
    }
    for level in range(1, REFINE + 1):
        for s in searched:
            centre = shape[s.name]
            for value in (centre - steps[s.name] / 2**level, centre + steps[s.name] / 2**level):
                if not s.low <= value <= s.high:
                    continue
                trial = bench.columns(*place, {**shape, s.name: float(value)})
                (better,) = regression.falls(trial.axis, trial.values, trial.values.shape[1])
                if better > fall:
                    shape, columns, fall = {**shape, s.name: float(value)}, trial, float(better)
    return shape, columns, fall

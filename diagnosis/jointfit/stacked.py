"""Columns of several effects side by side, tangents of their shapes, and how sure both are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.hypotheses.candidates import Bench
from flexhex.diagnosis.jointfit.effects import Part
from flexhex.diagnosis.jointfit.rotors import rotor_changes
from flexhex.diagnosis.regression.gram import inverted
from flexhex.diagnosis.regression.regression import Columns, Regression
from flexhex.fmus.common.effects import Shape

Array = NDArray[np.float64]
STEP, ALIKE = 1e-5, 1e-4
"""Half of the difference that a tangent is taken over, relative: to the shape's value, and at least
to the distance between two values of its grid, as a shape may be zero. Single precision tells 1e-7
of a column apart; a wave of 100 periods over the stroke turns by 0.006 rad. With a tenth of both
the intervals of an arm with friction and cogging move by 0.5 %, with ten times by 11 %; its names,
and those of an axis, stay.
"""
UNDETERMINED = 0.5
"""Standard deviation of a shape, relative to itself, beyond which the runs do not determine it."""


def stack(bench: Bench, regression: Regression, parts: Sequence[Part]) -> tuple[Array, Array]:
    """Columns of all parts (R, k) and tangents of their shapes (R, s)."""
    columns = [regression.spread(part.columns) for part in parts]
    stacked = np.hstack(columns)
    _, beta = regression.fall(Columns(None, stacked))
    gains = np.split(beta, np.cumsum([c.shape[1] for c in columns])[:-1])
    tangents = [
        _tangent(bench, regression, parts[k], name, gains[k])
        for k, name in shape_names(bench, parts)
    ]
    return stacked, np.hstack([np.zeros((len(stacked), 0)), *tangents])


def blends(bench: Bench, regression: Regression, parts: Sequence[Part]) -> list[Columns]:
    """What a share of another shape adds to parts of which real ones have several at once: it bends
    their gains, and is none of the model."""
    _, beta = regression.fall(
        Columns(None, np.hstack([regression.spread(part.columns) for part in parts]))
    )
    edges, columns = np.cumsum([part.columns.values.shape[1] for part in parts])[:-1], []
    for part, gains in zip(parts, np.split(beta, edges), strict=True):
        if shape := bench.blended(part.id, part.axis or 0, part.shape):
            other = part.moved(bench, shape).columns.values - part.columns.values
            columns.append(Columns(part.columns.axis, other @ gains[:, None]))
    return columns


@dataclass(frozen=True)
class Deviations:
    """Standard deviations of all gains (k,), and of the shapes of each part, infinite for one that
    the runs do not determine: gains are as unsure as that makes them. covariance: of the gains
    (k, k) with these shapes, as whether they are zero does not depend on shapes. bent: how far an
    error of the form as large as the effect moves each shape; turned: and gains (k,) with those."""

    gains: Array
    shapes: list[dict[str, float]]
    covariance: Array
    bent: list[dict[str, float]]
    turned: Array


def deviations_of(
    bench: Bench,
    regression: Regression,
    parts: Sequence[Part],
    columns: Array,
    tangents: Array,
) -> Deviations:
    """How sure gains and shapes are. A shape that the runs do not determine is kept, the least
    certain one first: left free it would take the gain with it. It may be another by as much as it
    is, or as these runs allow, and the gains with it. A mode as fast as can be told may be any
    faster: its frequency is not determined."""
    shaped, count = shape_names(bench, parts), columns.shape[1]
    sizes = np.array([_reach(bench, parts[k], name) for k, name in shaped])
    higher = np.array([_is_open(bench, parts[k], name) for k, name in shaped], dtype=bool)
    free = np.ones(len(shaped), dtype=bool)
    changes = rotor_changes(bench, regression, parts, columns)
    reach, far, still = *np.zeros((2, len(shaped))), ~columns.any(axis=0)
    together: Array | None = None
    while True:
        gain = regression.gain(Columns(None, np.hstack([columns, tangents[:, free]])), changes)
        together = gain.own if together is None else together
        deviation = np.sqrt(np.maximum(np.diag(gain.covariance), 0.0))
        deviation[gain.lost] = np.inf
        deviation[:count][still] = 0.0
        unsure = np.zeros(len(shaped))
        unsure[free] = np.where(higher[free], np.inf, deviation[count:] / sizes[free])
        if not (unsure > UNDETERMINED).any():
            break
        worst = int(np.argmax(unsure))
        free[worst], reach[worst] = False, sizes[worst] / np.hypot(1.0, 1 / unsure[worst])
    spread: list[dict[str, float]] = [{} for _ in parts]
    bent: list[dict[str, float]] = [{} for _ in parts]
    for k, name in shaped:
        spread[k][name] = bent[k][name] = np.inf
    far[free] = np.sqrt(np.maximum(np.diag(inverted(gain.own))[count:], 0.0))
    edges = np.cumsum([0, *(part.columns.values.shape[1] for part in parts)])
    for j, value in zip(np.flatnonzero(free), deviation[count:], strict=True):
        k, name = shaped[j]
        spread[k][name] = float(value)
        place = slice(edges[k], edges[k + 1])
        own = gain.beta[place]
        size = float(own @ gain.own[place, place] @ own)
        far[j] *= np.sqrt(max(size, 0.0))
        bent[k][name] = float(far[j])
    # what gains change by with a shape
    moved = inverted(together[:count, :count]) @ together[:count, count:]
    moved[still] = 0.0
    unsure, turned = (np.linalg.norm(moved * each, axis=1) for each in (reach, far))
    if free.any():
        gain = regression.gain(Columns(None, columns), changes)
    gains = np.hypot(deviation[:count], unsure)
    return Deviations(gains, spread, gain.covariance[:count, :count], bent, turned)


def _is_open(bench: Bench, part: Part, name: str) -> bool:
    """Whether a shape may be any higher, see `Shape.open`."""
    shape = bench.scales.ranges(part.id, part.axis or 0)[name]
    return shape.open and part.shape[name] >= shape.high


def _reach(bench: Bench, part: Part, name: str) -> float:
    """How far a shape could be from its value and still mean about the same."""
    shape = bench.scales.ranges(part.id, part.axis or 0)[name]
    value = abs(part.shape[name])
    return min(value, shape.high - shape.low) if shape.low >= 0 and value > 0 else shape.high


def _tangent(bench: Bench, regression: Regression, part: Part, name: str, beta: Array) -> Array:
    """Change of an effect's torque with a shape, one-sided at the shape's bounds."""
    shape = bench.scales.ranges(part.id, part.axis or 0)[name]
    low, high = beside(shape, part.shape[name])
    sides = [bench.columns(part.id, part.axis or 0, {**part.shape, name: v}) for v in (low, high)]
    change = Columns(sides[0].axis, (sides[1].values - sides[0].values) @ beta[:, None])
    return regression.spread(change) / (high - low)


def beside(shape: Shape, value: float) -> tuple[float, float]:
    """A value of a shape a little below and above one, within its bounds: by far less than makes
    another torque, by far more than single precision tells apart."""
    # bounds are those of the runs that are fitted, not of those in which it was found
    value = float(np.clip(value, shape.low, shape.high))
    apart = min((b - a for a, b in pairwise(sorted(shape.grid))), default=0.0)
    step = max(STEP * abs(value), ALIKE * apart)
    low, high = np.clip((value - step, value + step), shape.low, shape.high).tolist()
    return low, high


def shape_names(bench: Bench, parts: Sequence[Part]) -> list[tuple[int, str]]:
    """Shapes that were searched: number of the part, name."""
    names = []
    for k, part in enumerate(parts):
        item = bench.effects.get(part.id)
        if item is not None:
            names += [(k, s.name) for s in item.searched]
    return names

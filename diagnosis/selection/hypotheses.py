"""What could explain the data: an effect on an axis or on the whole, another base parameter."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.candidates import Bench
from flexhex.diagnosis.changed import NO_PARAMETER
from flexhex.diagnosis.selection.moments import Moments, Term
from flexhex.diagnosis.selection.orders import promising_orders
from flexhex.diagnosis.selection.rows import Rows

Array = NDArray[np.float64]
Axis = int | None
ORDER = ["order"]
"""Shapes of an effect that is a harmonic of the angle."""
WAVES, LENGTH, PLACES, CREEP = 100, 1.5, 40, 0.1
"""Of the generic hypothesis: waves over all quantities together, their length in standard
deviations; places along the stroke; rate, relative to its RMS, within which the direction turns."""


@dataclass(frozen=True)
class Products:
    """Of whitened columns with the model's (m, shapes * k), with the torque (shapes * k,) and with
    each other (shapes, k, k)."""

    cross: Array
    right: Array
    own: Array


@dataclass(frozen=True, eq=False)
class EffectHypothesis:
    """An effect with all shapes of its grid: raw (shapes, R, k) [N m] per unit of its gains on each
    axis that feels it, white the same whitened; low (k,): least gains; freedom: numbers that a fit
    may choose; extends: the simpler effect that it becomes without its further gains; choices:
    shapes that those of the grid were picked from."""

    id: str
    axis: Axis
    shapes: tuple[Mapping[str, float], ...]
    raw: Mapping[int, Array]
    white: Mapping[int, Array]
    low: Array
    freedom: int
    extends: str
    exact: bool
    most: int
    choices: int = 1

    @property
    def width(self) -> int:
        """Gains."""
        return len(self.low)

    def products(self, rows: Rows, fold: int) -> Products:
        """Products of the columns with the base model's, with the torque, and with each other;
        these not between passes: noise in a column must not make it seem small. Kept."""
        if fold not in self._products:
            part, width = rows.parts[fold], self.width
            count = len(self.shapes) * width
            cross, right = np.zeros((rows.nb, count)), np.zeros(count)
            own = np.zeros((len(self.shapes), width, width))
            for i, columns in self.stacked.items():
                cross += rows.twin_B[i][part].T @ columns[part]
                right += columns[part].T @ rows.twin_y[i][part]
                single = self.white[i][:, part]
                own += single.transpose(0, 2, 1) @ single
            self._products[fold] = Products(cross, right, own)
        return self._products[fold]

    def beside(self, term: Term, rows: Rows, fold: int) -> Array:
        """Products (k', shapes * k) of an accepted term's columns with these, between passes.
        Kept."""
        if (term, fold) not in self._beside:
            part, common = rows.parts[fold], term.white.keys() & self.stacked.keys()
            found = np.zeros((len(term.prior), len(self.shapes) * self.width))
            for i in common:
                found += (rows.twins[part] @ term.white[i]).T @ self.stacked[i][part]
            self._beside[term, fold] = found
        return self._beside[term, fold]

    @cached_property
    def _products(self) -> dict[int, Products]:
        return {}

    @cached_property
    def _beside(self) -> dict[tuple[Term, int], Array]:
        return {}

    @cached_property
    def stacked(self) -> dict[int, Array]:
        """Whitened columns (R, shapes * k) side by side."""
        return {
            i: np.ascontiguousarray(w.transpose(1, 0, 2)).reshape(w.shape[1], -1)
            for i, w in self.white.items()
        }


@dataclass(frozen=True)
class ChangedParameter:
    """Base parameters, at these places, that may leave their tolerances: one, or a body's."""

    id: str
    places: tuple[int, ...]
    axis: Axis
    extends: str = ""
    choices: int = 1

    @property
    def freedom(self) -> int:
        """A parameter that is there already is simpler than any effect."""
        return len(self.places) - 1


@dataclass(frozen=True, eq=False)
class Payload:
    """A payload that `runs` carried and the others did not; bench: of the base model with its
    columns; choices: ways to part the runs."""

    bench: Bench
    runs: tuple[str, ...]
    freedom: int
    choices: int
    id: str = "payload"
    axis: Axis = None
    extends: str = ""


Hypothesis = EffectHypothesis | ChangedParameter | Payload


class Hypotheses:
    """All hypotheses beside a calibrated base model; columns are made when asked for, and kept."""

    def __init__(self, bench: Bench, rows: Rows) -> None:
        self.bench, self.rows, self.moments = bench, rows, Moments(rows)
        self._effects: dict[tuple[str, Axis], EffectHypothesis] = {}
        self._generic: dict[int, EffectHypothesis] = {}
        self.loaded: dict[tuple[int, ...], Bench] = {}

    def effects(self, axis: Axis) -> Iterator[EffectHypothesis]:
        """Effects that an axis (None: the whole) may have."""
        for name in self.bench.names(axis):
            yield self.effect(name, axis)

    def effect(self, name: str, axis: Axis) -> EffectHypothesis:
        """An effect on an axis (None: on the whole); orders of the angle are those that the rows
        can show."""
        if (name, axis) not in self._effects:
            shapes, choices = self.bench.shapes(name, axis or 0), 1
            if axis is not None and shapes and list(shapes[0]) == ORDER:
                weight = self.rows.made.raw if self._loaded(name) else None
                orders, choices = promising_orders(self.rows, axis, weight)
                shapes = [{ORDER[0]: order} for order in orders]
            found = self._made(name, axis, shapes)
            self._effects[name, axis] = replace(found, choices=choices)
        return self._effects[name, axis]

    def shaped(self, effect: EffectHypothesis, shape: Mapping[str, float]) -> EffectHypothesis:
        """The same effect with one shape alone."""
        return replace(self._made(effect.id, effect.axis, [shape]), choices=effect.choices)

    def searched(self, effect: EffectHypothesis) -> list[tuple[str, float, float]]:
        """Shapes that may take any value: name and bounds."""
        item = self.bench.effects.get(effect.id)
        return [(s.name, s.low, s.high) for s in item.searched] if item else []

    def _loaded(self, name: str) -> bool:
        """Whether an effect goes with the torque."""
        return self.bench.effects[name].effect.acts_on == "drive"

    def _made(
        self, name: str, axis: Axis, shapes: Sequence[Mapping[str, float]]
    ) -> EffectHypothesis:
        at, item = axis or 0, self.bench.effects.get(name)
        thin = [self.bench.thin(name, at, shape) for shape in shapes]
        felt = range(self.rows.n) if thin[0][0].ndim == 3 else [at]
        raw, white = dict[int, Array](), dict[int, Array]()
        for i in felt:
            own = [[v[:, i] if v.ndim == 3 else v for v in listed] for listed in thin]
            raw[i] = np.stack([self.rows.raw(values) for values in own])
            white[i] = np.stack([self.rows.white(i, values) for values in own])
        width = next(iter(raw.values())).shape[2]
        if item is None:
            low, free = np.full(width, -np.inf), width
            return EffectHypothesis(name, axis, tuple(shapes), raw, white, low, free, "", False, 1)
        effect = item.effect
        low = np.array([gain.low for gain in effect.gains])
        known = (item.freedom, effect.extends, effect.exact, effect.most)
        return EffectHypothesis(name, axis, tuple(shapes), raw, white, low, *known)

    @cached_property
    def changes(self) -> Sequence[ChangedParameter]:
        """Base parameters that have a tolerance, and all of a body together."""
        single, bodies = list[ChangedParameter](), dict[str, list[int]]()
        for place, known in enumerate(self.rows.made.known):
            if 0 < known.tolerance < np.inf and known.group not in NO_PARAMETER:
                single.append(ChangedParameter(known.name, (place,), known.axis))
                owner, dot, _ = known.name.rpartition(".")
                if dot:
                    bodies.setdefault(owner, []).append(place)
        whole = [ChangedParameter(name, tuple(p), None) for name, p in bodies.items() if len(p) > 1]
        return [*single, *whole]

    def generic(self, axis: int) -> EffectHypothesis:
        """Something that has no name: a smooth function of an axis' angle, rate, acceleration and
        torque, and one local in angle and direction. Its torque is the axis' RMS for coefficients
        of one; kept."""
        if axis not in self._generic:
            found = self._quantities(axis)
            rng = np.random.default_rng(0)
            mixed = rng.normal(size=(len(found[0]), WAVES)) / LENGTH
            # each wave goes with about half of the quantities
            mixed *= rng.random(mixed.shape) < 0.5
            phase, unit = rng.uniform(0, 2 * np.pi, WAVES), np.sqrt(2.0 / WAVES)
            ends = (min(q[0].min() for q in found), max(q[0].max() for q in found))
            listed = []
            for angle, rate, acceleration, direction, torque in found:
                five = np.stack([angle, rate, acceleration, direction, torque], axis=1)
                local = _local(angle, ends)
                waves = unit * np.cos(five @ mixed + phase)
                parts = (waves, local, local * direction[:, None])
                listed.append(float(self.rows.torque_rms[axis]) * np.hstack(parts))
            raw, white = self.rows.raw(listed)[None], self.rows.white(axis, listed)[None]
            low = np.full(raw.shape[2], -np.inf)
            self._generic[axis] = EffectHypothesis(
                "generic", axis, ({},), {axis: raw}, {axis: white}, low, len(low), "", False, 1
            )
        return self._generic[axis]

    def _quantities(self, axis: int) -> list[tuple[Array, ...]]:
        """Angle, rate, acceleration, direction, torque of an axis at the rows (m,) of each block,
        of unit RMS over all blocks."""
        blocks = self.rows.made.blocks
        found = [
            [
                block.smooth(values[:, axis])
                for values in (
                    block.run.motion.theta,
                    block.run.motion.thetad,
                    block.run.motion.thetadd,
                    raw,
                )
            ]
            for block, raw in zip(blocks, self.rows.made.raw, strict=True)
        ]
        whole = [np.concatenate([own[k] for own in found]) for k in range(4)]
        centre, size = [w.mean() for w in whole], [max(float(w.std()), 1e-300) for w in whole]
        listed = list[tuple[Array, ...]]()
        for own in found:
            angle, rate, more, torque = (
                (v - c) / s for v, c, s in zip(own, centre, size, strict=True)
            )
            direction = np.tanh(own[1] / (CREEP * size[1]))
            listed.append((angle, rate, more, direction, torque))
        return listed


def _local(angle: Array, ends: tuple[float, float]) -> Array:
    """Hat functions (m, PLACES) over the angle, each on its part of the stroke."""
    place = (angle - ends[0]) / max(ends[1] - ends[0], 1e-300) * (PLACES - 1)
    return np.asarray(np.maximum(0.0, 1.0 - np.abs(place[:, None] - np.arange(PLACES))))

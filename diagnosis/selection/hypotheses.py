"""What could explain the data: an effect on an axis or on the whole, another base parameter."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.candidates import Bench
from flexhex.diagnosis.payloads import GROUP
from flexhex.diagnosis.selection.generic import generic
from flexhex.diagnosis.selection.moments import Moments, Term
from flexhex.diagnosis.selection.orders import promising_orders
from flexhex.diagnosis.selection.rows import Rows
from flexhex.fmus.common.effects import Shape

Array = NDArray[np.float64]
Axis = int | None
ORDER = ["order"]
"""Shapes of an effect that is a harmonic of the angle."""


@dataclass(frozen=True)
class Products:
    """Of whitened columns with the model's (m, shapes * k), with the torque (shapes * k,) and with
    each other (shapes, k, k)."""

    cross: Array
    right: Array
    own: Array


@dataclass(frozen=True)
class Columns:
    """Columns of all shapes side by side on each axis that feels them, per unit of their gains: raw
    (R, shapes * k) [N m], white the same whitened."""

    raw: Mapping[int, Array]
    white: Mapping[int, Array]


@dataclass(frozen=True, eq=False)
class EffectHypothesis:
    """An effect with all shapes of its grid. columns: makes them, as they take most of the memory;
    felt: axes that feel it; low, high (k,): least gains, largest ones or None for none; freedom:
    numbers that a fit may choose; extends:
    the simpler effect that it becomes without its further gains; choices: shapes that those of the
    grid were picked from."""

    id: str
    axis: Axis
    shapes: tuple[Mapping[str, float], ...]
    columns: Callable[[], Columns]
    felt: tuple[int, ...]
    low: Array
    freedom: int
    extends: str
    exact: bool
    most: int
    choices: int = 1
    high: Array | None = None

    @property
    def width(self) -> int:
        """Gains."""
        return len(self.low)

    @cached_property
    def _known(self) -> dict[Term | None, dict[int, Any]]:
        """Products with the base model, None, and with terms, of each fold."""
        return {}

    def products(self, rows: Rows, fold: int) -> Products:
        """Products of the columns with the base model's, with the torque, and with each other;
        these not between passes: noise in a column must not make it seem small. Kept."""
        if None not in self._known:
            white = self.columns().white
            self._known[None] = {f: self._products(rows, white, p) for f, p in rows.parts.items()}
        found: Products = self._known[None][fold]
        return found

    def _products(self, rows: Rows, white: Mapping[int, Array], part: slice) -> Products:
        width, count = self.width, len(self.shapes)
        cross, right = np.zeros((rows.nb, count * width)), np.zeros(count * width)
        own = np.zeros((count, width, width))
        for i, columns in white.items():
            cross += rows.twin_B[i][part].T @ columns[part]
            right += columns[part].T @ rows.twin_y[i][part]
            single = columns[part].reshape(-1, count, width).transpose(1, 2, 0)
            own += single @ single.transpose(0, 2, 1)
        return Products(cross, right, own)

    def beside(self, term: Term, rows: Rows, fold: int) -> Array:
        """Products (k', shapes * k) of an accepted term's columns with these, between passes.
        Kept."""
        if term not in self._known:
            common = term.white.keys() & set(self.felt)
            white = self.columns().white if common else {}
            empty = np.zeros((len(term.prior), len(self.shapes) * self.width))
            self._known[term] = {
                f: sum(((rows.twins[p] @ term.white[i]).T @ white[i][p] for i in common), empty)
                for f, p in rows.parts.items()
            }
        found: Array = self._known[term][fold]
        return found


@dataclass(frozen=True)
class NamelessHypothesis:
    """Columns of something without a name, and how their coefficients go together, each (k, k')."""

    columns: EffectHypothesis
    ways: tuple[Array, ...]


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
    """A payload that some runs carried; bench: of the base model with its columns; choices: ways to
    part the runs."""

    bench: Bench
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

    def searched(self, effect: EffectHypothesis) -> list[Shape]:
        """Shapes that may take any value between bounds."""
        return self.bench.searched(effect.id, effect.axis or 0)

    def _loaded(self, name: str) -> bool:
        """Whether an effect goes with the torque."""
        return self.bench.effects[name].effect.acts_on == "drive"

    def _made(
        self, name: str, axis: Axis, shapes: Sequence[Mapping[str, float]]
    ) -> EffectHypothesis:
        item = self.bench.effects.get(name)
        first = self._columns(name, axis, shapes[:1])
        felt, width = tuple(first.raw), next(iter(first.raw.values())).shape[1]

        def columns() -> Columns:
            return first if len(shapes) == 1 else self._columns(name, axis, shapes)

        made = (name, axis, tuple(shapes), columns, felt)
        if item is None:
            return EffectHypothesis(*made, np.full(width, -np.inf), width, "", False, 1)
        effect = item.effect
        bounds = np.array(self.bench.scales.bounds(name, axis or 0)).T
        known = (item.freedom, effect.extends, effect.exact, effect.most)
        return EffectHypothesis(*made, bounds[0], *known, high=bounds[1])

    def _columns(self, name: str, axis: Axis, shapes: Sequence[Mapping[str, float]]) -> Columns:
        thin = [self.bench.thin(name, axis or 0, shape) for shape in shapes]
        felt = range(self.rows.n) if thin[0][0].ndim == 3 else [axis or 0]
        raw, white = dict[int, Array](), dict[int, Array]()
        for i in felt:
            own = [
                np.hstack([v[:, i] if v.ndim == 3 else v for v in block])
                for block in zip(*thin, strict=True)
            ]
            raw[i], white[i] = self.rows.raw(own), self.rows.white(i, own)
        return Columns(raw, white)

    @cached_property
    def changes(self) -> Sequence[ChangedParameter]:
        """Base parameters that have a tolerance, and all of a body or of a group together."""
        single, bodies = list[ChangedParameter](), dict[str, list[int]]()
        for place, known in enumerate(self.rows.made.known):
            if 0 < known.tolerance < np.inf and known.group not in ("history", "delay", GROUP):
                single.append(ChangedParameter(known.name, (place,), known.axis))
                owner, dot, _ = known.name.rpartition(".")
                if dot:
                    bodies.setdefault(owner, []).append(place)
                if known.group != known.name:
                    bodies.setdefault(known.group, []).append(place)
        whole = [ChangedParameter(name, tuple(p), None) for name, p in bodies.items() if len(p) > 1]
        return [*single, *whole]

    def generic(self, axis: int) -> Sequence[NamelessHypothesis]:
        """What an axis may have without a name."""
        return [
            nameless(axis, f.argument, Columns({axis: f.raw}, {axis: f.white}), f.ways)
            for f in generic(self.rows, axis)
        ]


def nameless(
    axis: Axis, argument: str, made: Columns, ways: tuple[Array, ...]
) -> NamelessHypothesis:
    """Something without a name from its columns (R, k) on an axis or on several."""
    felt, count = tuple(made.raw), next(iter(made.raw.values())).shape[1]
    low = np.full(count, -np.inf)
    columns = EffectHypothesis(argument, axis, ({},), lambda: made, felt, low, count, "", False, 1)
    return NamelessHypothesis(columns, ways)

"""One thing that could explain the data, with its columns and their products with the rows."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.hypotheses.candidates import Bench
from flexhex.diagnosis.regression.design import RowSelection
from flexhex.diagnosis.selection.changed import Axis, ChangedParameter
from flexhex.diagnosis.selection.moments import Moments, Term
from flexhex.diagnosis.selection.products import Products, ShapeProducts, placed
from flexhex.diagnosis.selection.rows import Rows

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ColumnsByAxis:
    """Columns (R, k) of one shape on each axis that feels them, per unit of its gains: raw [N m],
    white the same whitened."""

    raw: Mapping[int, Array]
    white: Mapping[int, Array]


@dataclass(frozen=True, eq=False)
class EffectHypothesis:
    """An effect with all shapes of its grid. columns: makes whitened ones (R, shapes * k) of some
    shapes, side by side, on each axis that feels them, as they take most of the memory; felt: axes
    that feel it; low, high (k,): least gains, largest ones; least: numbers that a fit may choose;
    optional: shapes that may be left out, and what that means; extends: the simpler effect that it
    becomes without its further gains; limit: that at an end of its shape's range;
    choices: shapes that those of the grid were picked from; first: places of those that are looked
    at first, of all if there are none; taken: makes of a shape the share (R,) of a change of the
    reported torque that a gain of one takes away, if the columns are of that torque;
    slow: it goes with angle, rate and time alone; varied: see `Effect`; ordered: pairs of gains of
    which the first is at most so many times the second; known: of each shape."""

    id: str
    axis: Axis
    shapes: tuple[Mapping[str, float], ...]
    columns: Callable[[Sequence[Mapping[str, float]]], Mapping[int, Array]]
    felt: tuple[int, ...]
    low: Array
    high: Array
    least: int
    extends: str
    exact: bool
    most: int
    optional: Mapping[str, float] = field(default_factory=dict)
    choices: int = 1
    first: tuple[int, ...] = ()
    taken: Callable[[Mapping[str, float]], Array] | None = None
    slow: bool = False
    limit: str = ""
    varied: bool = False
    ordered: tuple[tuple[int, int, float], ...] = ()
    known: tuple[ShapeProducts, ...] = field(default_factory=lambda: (ShapeProducts(),))
    _base: list[tuple[Array, Array, Array]] = field(default_factory=list, init=False)

    @property
    def width(self) -> int:
        """Gains."""
        return len(self.low)

    @property
    def freedom(self) -> int:
        """Numbers that a fit may choose of the shape that stands first."""
        used = [name for name, out in self.optional.items() if self.shapes[0][name] != out]
        return self.least + len(used)

    def forget(self) -> None:
        """Let go of products; they are made again when asked for."""
        self._base.clear()
        vars(self).pop("_with", None)

    def blind(self, rows: Rows, left: int | None, gains: Array) -> Array:
        """What the log density of the torques of all folds but one loses (shapes,) [nats], with
        these gains (shapes, 1), because not all of the torque shows in the motion.

        With p(f(u)) known, p(u) = p(f(u)) |df/du|: beyond a limit the motion is the same whatever
        is reported, which is then known to its own size alone, as without any model.
        """
        if self.axis is None or self.taken is None:
            return np.zeros(len(gains))
        seen = np.maximum(1 - self._taken * gains[:, 0], 1 / rows.white_rms[self.axis])
        kept = (rows.fold != left) & rows.moving[self.axis]
        return np.asarray(np.log(np.minimum(seen[kept], 1.0)).sum(axis=0))

    @cached_property
    def _taken(self) -> Array:
        assert self.taken is not None
        pairs = zip(self.shapes, self.known, strict=True)
        return np.stack([known.share(self.taken, shape) for shape, known in pairs], axis=1)

    def beside(self, moments: Moments) -> Products:
        """Products of all shapes' columns with a model's; of each shape kept, as a search comes
        back to it beside many models."""
        common = [t for t in moments.terms if t.white.keys() & set(self.felt)]
        self._fill_beside(common, moments)
        with_base, right, own = self._with_base(moments.rows)
        cross = np.zeros((*with_base.shape[:2], moments.m, with_base.shape[3]))
        cross[:, :, : moments.rows.nb] = with_base
        for term in common:
            cross[:, :, moments.place(term)] = self._with[term]
        return Products(moments.rows.folds, cross, right, own)

    def _with_base(self, rows: Rows) -> tuple[Array, Array, Array]:
        """With the base model's columns, with the torque, with each other, of all shapes."""
        if not self._base:
            new = [s for s, known in enumerate(self.known) if known.base is None]
            made = self._products(rows, new) if new else None
            parts = [known.base for known in self.known if known.base is not None]
            if made is None or len(new) < len(parts):
                cross, right, own = zip(*parts, strict=True)
                made = np.concatenate(cross, 3), np.concatenate(right, 1), np.concatenate(own, 1)
            self._base.append(made)
        return self._base[0]

    def _products(self, rows: Rows, new: Sequence[int]) -> tuple[Array, Array, Array]:
        """Of some shapes, which know their part from then on. Products of columns with each other
        are not between passes: noise in a column must not make it seem small."""
        folds, k, size = len(rows.folds), self.width, len(new) * self.width
        count = 1 + rows.repeated
        cross, right = np.zeros((count, folds, rows.nb, size)), np.zeros((folds, size))
        own = np.zeros((folds, len(new), k, k))
        for i, columns in self._white(new).items():
            ways = rows.ways(columns)
            for f, part in enumerate(rows.parts.values()):
                for whole, values in zip(cross, ways, strict=True):
                    whole[f] += rows.white_B.pulled(i, values[part], part)
                right[f] += columns[part].T @ rows.twin_y[i][part]
                single = columns.T[:, part].reshape(len(new), k, -1)
                own[f] += single @ single.transpose(0, 2, 1)
        for at, j, s in placed(new, self.width):
            self.known[s].base = cross[..., at], right[:, at], own[:, j : j + 1]
        return cross, right, own

    @cached_property
    def _with(self) -> WeakKeyDictionary[Term, Array]:
        """Products with accepted terms (ways, folds, k', shapes * k) that are known already."""
        return WeakKeyDictionary()

    def _fill_beside(self, terms: Sequence[Term], moments: Moments) -> None:
        """With the columns of accepted terms."""
        lacking = dict[tuple[int, ...], list[Term]]()
        unknown = [term for term in terms if term not in self._with]
        for term in unknown:
            new = tuple(s for s, known in enumerate(self.known) if term not in known.terms)
            lacking.setdefault(new, []).append(term)
        lacking.pop((), None)
        parts = moments.rows.parts.values()
        for new, own in lacking.items():
            white = self._white(new)
            for term in own:
                whole = np.stack([_products_of(of, white, parts) for of in moments.both(term)])
                for at, _, s in placed(new, self.width):
                    self.known[s].terms[term] = whole[..., at]
        for term in unknown:
            self._with[term] = np.concatenate([known.terms[term] for known in self.known], 3)

    def _white(self, chosen: Sequence[int]) -> Mapping[int, Array]:
        return self.columns([self.shapes[s] for s in chosen])


def _products_of(
    ones: Mapping[int, Array], others: Mapping[int, Array], parts: Collection[RowSelection]
) -> Array:
    """Products (folds, k', k) of columns on the same axes."""
    common = [(ones[i], others[i]) for i in ones.keys() & others.keys()]
    return np.stack([sum((a[p].T @ b[p] for a, b in common), 0.0) for p in parts])


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
    varied: bool = False


Hypothesis = EffectHypothesis | ChangedParameter | Payload

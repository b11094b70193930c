"""One thing that could explain the data, with its columns and their products with the rows."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.candidates import Bench
from flexhex.diagnosis.selection.criteria import Criteria
from flexhex.diagnosis.selection.moments import Term
from flexhex.diagnosis.selection.rows import Rows

Array = NDArray[np.float64]
Axis = int | None
AGAIN = 1.0
"""One standard deviation of the mass of a body that may be another one, relative to the file's."""


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
    (R, shapes * k) [N m] where there is one shape alone, white the same whitened."""

    raw: Mapping[int, Array]
    white: Mapping[int, Array]


@dataclass(frozen=True, eq=False)
class EffectHypothesis:
    """An effect with all shapes of its grid. columns: makes them, as they take most of the memory;
    felt: axes that feel it; low, high (k,): least gains, largest ones or None for none; freedom:
    numbers that a fit may choose; extends: the simpler effect that it becomes without its further
    gains; choices: shapes that those of the grid were picked from; taken: makes the share
    (R, shapes) of a change of the reported torque that a gain of one takes away, if the columns
    are of that torque; ordered: pairs of gains of which the first is at most so many
    times the second."""

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
    taken: Callable[[], Array] | None = None
    ordered: tuple[tuple[int, int, float], ...] = ()

    @property
    def width(self) -> int:
        """Gains."""
        return len(self.low)

    def blind(self, rows: Rows, left: int | None, gains: Array) -> Array:
        """What the log density of the torques of all folds but one loses (shapes,) [nats], with
        these gains (shapes, 1), because not all of the torque shows in the motion.

        With p(f(u)) known, p(u) = p(f(u)) |df/du|: beyond a limit the motion is the same whatever
        is reported, which is then known to its own size alone, as without any model.
        """
        if self.axis is None or self.taken is None:
            return np.zeros(len(gains))
        seen = np.maximum(1 - self._taken * gains[:, 0], 1 / rows.white_rms[self.axis])
        kept = (rows.fold != left) & (rows.moving[self.axis] > 0)
        return np.asarray(np.log(np.minimum(seen[kept], 1.0)).sum(axis=0))

    @cached_property
    def _taken(self) -> Array:
        assert self.taken is not None
        return self.taken()

    @cached_property
    def _known(self) -> dict[Term | None, dict[int, Any]]:
        """Products with the base model, None, and with terms, of each fold."""
        return {}

    def products(self, rows: Rows, fold: int) -> Products:
        """Products of the columns with the base model's, with the torque, and with each other;
        these not between passes: noise in a column must not make it seem small. Kept."""
        if None not in self._known:
            self._known[None] = self._products(rows)
        found: Products = self._known[None][fold]
        return found

    def _products(self, rows: Rows) -> dict[int, Products]:
        width, count = self.width, len(self.shapes)
        size = count * width
        found = {
            f: Products(np.zeros((rows.nb, size)), np.zeros(size), np.zeros((count, width, width)))
            for f in rows.folds
        }
        for i, columns in self.columns().white.items():
            across = rows.across(columns)
            for f, part in rows.parts.items():
                found[f].cross[:] += rows.white_B.pulled(i, across[part], part)
                found[f].right[:] += columns[part].T @ rows.twin_y[i][part]
                single = columns[part].reshape(-1, count, width).transpose(1, 2, 0)
                found[f].own[:] += single @ single.transpose(0, 2, 1)
        return found

    def beside(self, term: Term, rows: Rows, fold: int) -> Array:
        """Products (k', shapes * k) of an accepted term's columns with these, between passes.
        Kept."""
        if term not in self._known:
            common = term.white.keys() & set(self.felt)
            white = self.columns().white if common else {}
            twins = {i: rows.across(term.white[i]) for i in common}
            empty = np.zeros((len(term.prior), len(self.shapes) * self.width))
            self._known[term] = {
                f: sum((twins[i][p].T @ white[i][p] for i in common), empty)
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
    """Base parameters, at these places, that may leave their tolerances: one, or a body's. beside:
    its size is what others cannot make up for."""

    id: str
    places: tuple[int, ...]
    axis: Axis
    extends: str = ""
    choices: int = 1
    beside: bool = True

    @property
    def ways(self) -> Array:
        """Directions (len(places), k) in which they may leave their tolerances."""
        return np.eye(len(self.places))

    def deviation(self, criteria: Criteria) -> float:
        """How far they may, one standard deviation of each direction."""
        return criteria.loose

    def possible(self, gains: Array) -> bool:
        """Whether a machine can have these gains (k,) of the directions."""
        return True

    @property
    def freedom(self) -> int:
        """A parameter that is there already is simpler than any effect."""
        return len(self.places) - 1


@dataclass(frozen=True, eq=False)
class HeavierBody(ChangedParameter):
    """A body with another mass, and all that goes with it; direction (len(places),): coefficients
    of as much again as the machine file says. Other parameters could make all of its torque, if no
    tolerance held them: so all of it is its size."""

    beside: bool = False
    direction: Array = field(default_factory=lambda: np.zeros(0))

    @property
    def ways(self) -> Array:
        """All in step."""
        return self.direction[:, None]

    def deviation(self, criteria: Criteria) -> float:
        """Nothing, or twice what the file says."""
        return AGAIN

    def possible(self, gains: Array) -> bool:
        """A body has a mass."""
        return bool(gains[0] > -1.0)

    @property
    def freedom(self) -> int:
        """One number is another, as of a parameter."""
        return 0


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


def nameless(
    axis: Axis, argument: str, made: Columns, ways: tuple[Array, ...]
) -> NamelessHypothesis:
    """Something without a name from its columns (R, k) on an axis or on several."""
    felt, count = tuple(made.raw), next(iter(made.raw.values())).shape[1]
    low = np.full(count, -np.inf)
    columns = EffectHypothesis(argument, axis, ({},), lambda: made, felt, low, count, "", False, 1)
    return NamelessHypothesis(columns, ways)

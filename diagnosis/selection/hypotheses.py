"""What could explain the data: an effect on an axis or on the whole, another base parameter."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.hypotheses.candidates import Bench
from flexhex.diagnosis.selection.changed import Axis, ChangedParameter
from flexhex.diagnosis.selection.expected import expected
from flexhex.diagnosis.selection.generic import generic
from flexhex.diagnosis.selection.hypothesis import ColumnsByAxis, EffectHypothesis
from flexhex.diagnosis.selection.keep import Keep
from flexhex.diagnosis.selection.moments import Moments, Term
from flexhex.diagnosis.selection.orders import ANEW, OVERTONES, TRIED, Orders, fundamentals
from flexhex.diagnosis.selection.others import others
from flexhex.diagnosis.selection.products import ShapeProducts
from flexhex.diagnosis.selection.rows import Rows
from flexhex.diagnosis.selection.seen import Seen
from flexhex.diagnosis.selection.survey import first_of
from flexhex.diagnosis.selection.unnamed import NamelessHypothesis, nameless
from flexhex.fmus.common.effects import Shape

Array = NDArray[np.float64]
ORDER = ["order"]
"""Shapes of an effect that is a harmonic of the angle."""


class Hypotheses:
    """All hypotheses beside a calibrated base model; columns are made when asked for, and kept.

    imitated, longer: see `lookalike.py`.
    """

    def __init__(self, bench: Bench, rows: Rows) -> None:
        self.bench, self.rows = bench, rows
        self.moments = Moments(rows)
        self._effects: dict[tuple[str, Axis], EffectHypothesis] = {}
        self._anew: dict[tuple[str, Axis, str], EffectHypothesis] = {}
        self._shaped: dict[tuple[object, ...], EffectHypothesis] = {}
        self._known = dict[tuple[object, ...], ShapeProducts]()
        self._keep = Keep()
        self.seen = Seen(rows, bench.effects)
        self.imitated = dict[tuple[str, Axis], Term]()
        self.longer: tuple[Moments, tuple[str, Axis], Moments] | None = None
        self.loaded: dict[tuple[int, ...], Bench] = {}

    def forget(self) -> None:
        """Let go of columns and products, most of the memory; scores still refer to all else."""
        self._keep.forget()
        self.seen.forget()
        self.imitated.clear()
        self.longer = None
        for known in self._known.values():
            known.forget()
        for effect in (*self._effects.values(), *self._anew.values(), *self._shaped.values()):
            effect.forget()
        self.bench.forget()

    def effects(self, axis: Axis) -> Iterator[EffectHypothesis]:
        """Effects that an axis (None: the whole) may have."""
        for name in self.bench.names(axis):
            effect = self.effect(name, axis)
            if effect.shapes:
                yield effect

    def effect(self, name: str, axis: Axis) -> EffectHypothesis:
        """An effect on an axis (None: on the whole); orders of the angle are those that the rows
        can show, which may be none."""
        if (name, axis) not in self._effects:
            shapes = self.bench.shapes(name, axis or 0)
            if axis is not None and shapes and list(shapes[0]) == ORDER:
                found = self._waves(
                    name, axis, self.seen.promising(self.moments, name, axis, TRIED)
                )
            else:
                found = self._hypothesis(name, axis, shapes)
                searched = [shape.name for shape in self.searched(found)]
                found = replace(found, first=first_of(shapes, searched))
            self._effects[name, axis] = found
        return self._effects[name, axis]

    def anew(
        self, moments: Moments, effect: EffectHypothesis, own: str, orders: Sequence[float]
    ) -> list[EffectHypothesis]:
        """The same effect with the orders that a model leaves, which its own effects on the axis,
        as a text, hid before; and with whole multiples of its orders on any axis: nobody had to
        look for these, so they may be faint."""
        axis, name, hypotheses = effect.axis, effect.id, list[EffectHypothesis]()
        if axis is None or list(effect.shapes[0]) != ORDER:
            return []
        if own:
            key = name, axis, own
            if key not in self._anew:
                listed = self.seen.promising(moments, name, axis, ANEW)
                self._anew[key] = self._waves(name, axis, listed)
            hypotheses += [self._anew[key]] if self._anew[key].shapes else []
        if waves := fundamentals(orders):
            key = name, axis, repr(waves)
            if key not in self._anew:
                every = [{ORDER[0]: k * o} for o in waves for k in range(1, OVERTONES + 1)]
                seen = [s for s in every if self.bench.scales.possible(name, axis, s)]
                self._anew[key] = self._hypothesis(name, axis, seen)
            hypotheses += [self._anew[key]] if self._anew[key].shapes else []
        return hypotheses

    def _waves(self, name: str, axis: int, listed: Orders) -> EffectHypothesis:
        """An effect with these orders of the angle."""
        hypothesis = self._hypothesis(name, axis, [{ORDER[0]: order} for order in listed.orders])
        return replace(hypothesis, choices=listed.choices, first=listed.peaks)

    def shaped(self, effect: EffectHypothesis, *shapes: Mapping[str, float]) -> EffectHypothesis:
        """The same effect with other shapes; kept, as a search comes back to its shapes."""
        wanted = [tuple(sorted(shape.items())) for shape in shapes]
        key = effect.id, effect.axis, *wanted, effect.choices
        if key not in self._shaped:
            known = tuple(self._known_of(effect.id, effect.axis, shape) for shape in shapes)
            self._shaped[key] = replace(effect, shapes=shapes, known=known, first=())
        return self._shaped[key]

    def searched(self, effect: EffectHypothesis) -> list[Shape]:
        """Shapes that may take any value between bounds."""
        return self.bench.searched(effect.id, effect.axis or 0)

    def blended(
        self, effect: EffectHypothesis, shape: Mapping[str, float]
    ) -> Mapping[str, float] | None:
        """See `Bench.blended`."""
        return self.bench.blended(effect.id, effect.axis or 0, shape)

    def with_torque(self, name: str) -> bool:
        """Whether an effect goes with the torque."""
        known = self.bench.effects.get(name)
        return known is not None and known.effect.acts_on == "drive"

    def with_angle(self, name: str) -> bool:
        """Whether an effect goes with the angle of its axis alone."""
        known = self.bench.effects.get(name)
        return known is not None and known.placed

    def _hypothesis(
        self, name: str, axis: Axis, shapes: Sequence[Mapping[str, float]]
    ) -> EffectHypothesis:
        item = self.bench.effects.get(name)
        first = self._white(name, axis, shapes[:1]) if shapes else {}
        felt, width = tuple(first), next((v.shape[1] for v in first.values()), 0)
        known = tuple(self._known_of(name, axis, shape) for shape in shapes)

        def columns(chosen: Sequence[Mapping[str, float]]) -> Mapping[int, Array]:
            white = self._white(name, axis, chosen)
            noisy = item is not None and item.effect.geared == "torque"
            return expected(self.moments, white) if noisy else white

        common = (name, axis, tuple(shapes), columns, felt)
        if item is None:
            most = np.full(width, np.inf)
            return EffectHypothesis(*common, -most, most, width, "", False, 1, known=known)
        effect = item.effect
        low, high = np.array(self.bench.scales.bounds(name, axis or 0)).T

        def taken(shape: Mapping[str, float]) -> Array:
            return self.rows.raw(self.bench.taken(name, axis or 0, shape))

        return EffectHypothesis(
            *common,
            low,
            high,
            item.freedom,
            effect.extends,
            # columns of a lag or a delay are exact about its time
            effect.exact or bool(effect.line and self.bench.model.fitted.lag),
            effect.most,
            {s.name: s.start for s in effect.shapes if s.optional},
            taken=taken if effect.entered else None,
            slow=item.slow,
            limit=effect.limit,
            varied=effect.varied,
            ordered=self.bench.ordered(name, axis or 0),
            known=known,
        )

    def columns(self, effect: EffectHypothesis, shape: Mapping[str, float]) -> ColumnsByAxis:
        """Columns of one shape of an effect."""
        thin = self._thin(effect.id, effect.axis, shape)
        raw = {i: self.rows.raw(own) for i, own in thin.items()}
        return ColumnsByAxis(raw, self._white(effect.id, effect.axis, [shape]))

    def _thin(
        self, name: str, axis: Axis, shape: Mapping[str, float]
    ) -> Mapping[int, Sequence[Array]]:
        """Smoothed columns (m, k) of each block, of each axis that feels them."""
        thin = self.bench.thin(name, axis or 0, shape)
        if thin[0].ndim == 3:
            return {i: [v[:, i] for v in thin] for i in range(self.rows.n)}
        return {axis or 0: thin}

    def _white(
        self, name: str, axis: Axis, shapes: Sequence[Mapping[str, float]]
    ) -> Mapping[int, Array]:
        """Whitened columns (R, shapes * k) of each axis that feels them; kept shape by shape."""
        keys = [(name, axis, tuple(shape.items())) for shape in shapes]
        new = {key: shape for key, shape in zip(keys, shapes, strict=True) if key not in self._keep}
        if new:
            thin, columns = [self._thin(name, axis, shape) for shape in new.values()], {}
            for i in thin[0]:
                own = [np.hstack(block) for block in zip(*(t[i] for t in thin), strict=True)]
                columns[i] = self.rows.white(i, own)
            self._keep.add(list(new), columns)
        return self._keep.side_by_side(keys)

    def _known_of(self, name: str, axis: Axis, shape: Mapping[str, float]) -> ShapeProducts:
        """Products of a shape that are known already, whichever grid it is in."""
        return self._known.setdefault((name, axis, tuple(shape.items())), ShapeProducts())

    @cached_property
    def changes(self) -> Sequence[ChangedParameter]:
        """See `others`."""
        return others(self.rows.model)

    def generic(self, axis: int) -> Sequence[NamelessHypothesis]:
        """What an axis may have without a name."""
        listed, within = list[NamelessHypothesis](), None
        for f in reversed(generic(self.rows, axis)):
            columns = ColumnsByAxis({axis: f.raw}, {axis: f.white})
            listed.append(nameless(axis, f.argument, columns, f.ways, within, f.place))
            within = listed[0].columns
        return listed[::-1]

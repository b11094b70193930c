"""Waves over the angle in what a model leaves: those worth a try, and whether one stands out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.hypotheses.compiled import Compiled
from flexhex.diagnosis.selection.hypothesis import EffectHypothesis
from flexhex.diagnosis.selection.moments import Moments
from flexhex.diagnosis.selection.orders import (
    SHOWN,
    Orders,
    Waves,
    by_size,
    promising_orders,
    stands_out,
    waves,
)
from flexhex.diagnosis.selection.rows import Rows

Array = NDArray[np.float64]


class Seen:
    """What the rows of each axis show of waves, beside a model."""

    def __init__(self, rows: Rows, effects: Mapping[str, Compiled]) -> None:
        self.rows, self.effects = rows, effects
        self._waves = dict[int, Waves]()

    def forget(self) -> None:
        """Let go of it; it is found again when asked for."""
        self._waves.clear()

    def promising(self, moments: Moments, name: str, axis: int, most: int) -> Orders:
        """Orders at which an effect may explain most of what a model leaves."""
        return promising_orders(self._of(axis), self._left(moments, name, axis), most)

    def clear(self, moments: Moments, effect: object, order: float | None) -> bool:
        """Whether a wave with an order that was picked from many is none that chance makes of what
        a model leaves: errors of other effects' forms are no noise, and have waves of all orders.
        """
        if not isinstance(effect, EffectHypothesis) or effect.axis is None or order is None:
            return True
        if effect.choices < SHOWN:
            return True
        left = self._left(moments, effect.id, effect.axis)
        return stands_out(self._of(effect.axis), left, order)

    def _of(self, axis: int) -> Waves:
        if axis not in self._waves:
            self._waves[axis] = waves(self.rows, axis)
        return self._waves[axis]

    def _left(self, moments: Moments, name: str, axis: int) -> Sequence[Array]:
        left = self.rows.y[axis] - moments.torque(axis, moments.fit(None).q)
        return by_size(self.rows, axis, self.effects[name].effect, left)

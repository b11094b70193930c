"""What could explain the data: an effect on an axis or on the whole, another base parameter."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.candidates import Bench
from flexhex.diagnosis.selection.moments import Moments
from flexhex.diagnosis.selection.rows import Rows, kept

Array = NDArray[np.float64]
Axis = int | None


@dataclass(frozen=True, eq=False)
class EffectHypothesis:
    """An effect with all shapes of its grid: raw (shapes, R, k) [N m] per unit of its gains on each
    axis that feels it, white the same whitened; low (k,): least gains; freedom: numbers that a fit
    may choose; extends: the simpler effect that it becomes without its further gains."""

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

    @property
    def width(self) -> int:
        """Gains."""
        return len(self.low)

    def products(self, rows: Rows, fold: int) -> tuple[Array, Array]:
        """Products of the columns with the torque (shapes * k,), and with each other (shapes, k, k);
        these not between passes: noise in a column must not make it seem small."""
        if fold not in self._products:
            where, width = rows.fold == fold, self.width
            right = np.zeros(len(self.shapes) * width)
            own = np.zeros((len(self.shapes), width, width))
            for i, columns in self.stacked.items():
                right += rows.between(columns, rows.white_y[i], where)
                single = self.white[i][:, where]
                own += np.einsum("sra,srb->sab", single, single)
            self._products[fold] = right, own
        return self._products[fold]

    @cached_property
    def _products(self) -> dict[int, tuple[Array, Array]]:
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
    """A base parameter, at this place, that may leave its tolerance."""

    id: str
    place: int
    axis: Axis
    freedom: int = 0
    extends: str = ""


Hypothesis = EffectHypothesis | ChangedParameter


class Hypotheses:
    """All hypotheses beside a calibrated base model; columns are made when asked for, and kept."""

    def __init__(self, bench: Bench, rows: Rows) -> None:
        self.bench, self.rows, self.moments = bench, rows, Moments(rows)
        self._effects: dict[tuple[str, Axis], EffectHypothesis] = {}

    def effects(self, axis: Axis) -> Iterator[EffectHypothesis]:
        """Effects that an axis (None: the whole) may have."""
        for name in self.bench.names(axis):
            yield self.effect(name, axis)

    def effect(self, name: str, axis: Axis) -> EffectHypothesis:
        """An effect on an axis (None: on the whole)."""
        if (name, axis) not in self._effects:
            self._effects[name, axis] = self._made(name, axis)
        return self._effects[name, axis]

    def _made(self, name: str, axis: Axis) -> EffectHypothesis:
        at, item = axis or 0, self.bench.effects.get(name)
        shapes = self.bench.shapes(name, at)
        thin = [self.bench.thin(name, at, shape) for shape in shapes]
        felt = range(self.rows.n) if thin[0][0].ndim == 3 else [at]
        raw, white = dict[int, Array](), dict[int, Array]()
        for i in felt:
            own = [[v[:, i] if v.ndim == 3 else v for v in listed] for listed in thin]
            raw[i] = np.stack([kept(self.rows.made, values) for values in own])
            white[i] = np.stack([self.rows.made.white(i, values) for values in own])
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
        """Base parameters that have a tolerance."""
        return [
            ChangedParameter(known.name, place, known.axis)
            for place, known in enumerate(self.rows.made.known)
            if 0 < known.tolerance < np.inf and known.group not in ("history", "delay")
        ]

    @cached_property
    def smooth(self) -> list[Array]:
        """Smooth functions (R, K) of an axis' own angle, rate and torque, of unit RMS: by these
        the form of an effect may be wrong."""
        made, found = self.rows.made, []
        for i in range(self.rows.n):
            motions = [block.run.motion for block in made.blocks]
            angle, rate, torque = (
                _unit(kept(made, [b.smooth(v) for b, v in zip(made.blocks, values, strict=True)]))
                for values in (
                    [m.theta[:, i] for m in motions],
                    [m.thetad[:, i] for m in motions],
                    [raw[:, i] for raw in made.raw],
                )
            )
            listed = (angle, rate, torque, angle**2, rate**2, torque**2, angle * rate, np.abs(rate))
            found.append(np.stack([_unit(v) for v in (*listed, np.tanh(10.0 * rate))], axis=1))
        return found


def _unit(values: Array) -> Array:
    """Values (R,) about their mean, of unit RMS."""
    about = values - values.mean()
    return np.asarray(about / max(float(about.std()), 1e-300))

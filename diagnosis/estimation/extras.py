"""Effects that a diagnosis found, fitted beside a base model.

    tau = Y p + friction + sum gain column(shape)

The gains are estimated anew with all other parameters. So are the shapes of which the diagnosis
says how sure they are, by the change of the torque with each; the others stay as they were found.
Dry and viscous friction and an offset are in every identification already.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Known
from flexhex.diagnosis.estimation.changes import Change
from flexhex.diagnosis.estimation.friction import PARAMETER
from flexhex.diagnosis.hypotheses.candidates import Bench
from flexhex.diagnosis.hypotheses.compiled import compiled
from flexhex.diagnosis.kinds import kinds_of
from flexhex.diagnosis.regression.calibrate import Calibrated
from flexhex.diagnosis.regression.fitted import FixedEffect
from flexhex.fmus.common.effects import Effect, Shape
from flexhex.fmus.common.errors import UsageError
from flexhex.fmus.common.machine.effect_use import EffectUse

Array = NDArray[np.float64]
GROUP = "effect"
IDLE = 1e-12
"""Torque of a gain of one, relative to that of its axis, below which an effect does nothing."""
WEAK, STEP = 3.0, 0.1
"""Standard deviation of a shape's prior, in those of the diagnosis: wide, as both come from the
same runs; and step of the difference that shows its torque, in the same unit. Halved or doubled
they change an interval by 5 % at most (two belt axes)."""


@dataclass(frozen=True)
class Extra:
    """An effect on an axis, from 0, with its shape and gains; number: which of several on one axis.
    deviation: standard deviations of the shapes that are known by one."""

    effect: Effect
    axis: int
    shape: Mapping[str, float]
    number: int = 1
    gains: tuple[float, ...] = ()
    deviation: Mapping[str, float] = field(default_factory=dict)

    @property
    def free(self) -> list[Shape]:
        """Shapes that are estimated."""
        return [shape for shape in self.effect.shapes if shape.name in self.deviation]

    def parameter(self, name: str) -> str:
        """A gain's or shape's name among all parameters: `cogging_harmonic.a[2]`."""
        more = f"_{self.number}" if self.number > 1 else ""
        return f"{self.effect.id}{more}.{name}[{self.axis + 1}]"


@dataclass(frozen=True)
class Extras:
    """What is fitted beside; notes: what is not, and why; where: what says so; changed: parameters
    of the base model and payloads; last: the last axis that anything is on, from 1; file: effects
    that the model's file has, and what is written there, by the names of parameters."""

    listed: tuple[Extra, ...] = ()
    notes: tuple[str, ...] = ()
    where: str = ""
    changed: tuple[Change, ...] = ()
    last: int = 0
    file: tuple[EffectUse, ...] = ()
    written: Mapping[str, float] = field(default_factory=dict)

    @property
    def lag(self) -> float:
        """Lag or delay of the drive of a single axis [s], 0 for none."""
        return sum(gain for one in self.listed if one.effect.line for gain in one.gains)

    def losses(self, n: int) -> Array:
        """Shares (n,) of the reported torques that the joints do not get."""
        losses = np.zeros(n)
        for one in self.listed:
            if one.effect.loses:
                losses[one.axis] = sum(one.gains)
        return losses

    def effects(self, n: int) -> list[FixedEffect]:
        """All of them as they are now; none if the torque of no effect goes with a torque."""
        known = {c.effect.id: c for c in compiled(n, {e.effect.id: e.effect for e in self.listed})}
        pairs = [(known[one.effect.id], one) for one in self.listed if one.gains]
        own = [(c, one) for c, one in pairs if not (c.effect.loses or c.effect.line)]
        if all(item.moved for item, _ in own):
            return []
        return [FixedEffect(c, one.axis, one.shape, np.array(one.gains)) for c, one in own]

    def beside(self, friction: Sequence[Known]) -> list[Known]:
        """Parameters of friction without those that an effect has in its gains."""
        twice = {
            f"{PARAMETER[one.effect.extends]}[{one.axis + 1}]"
            for one in self.listed
            if one.effect.extends in PARAMETER
        }
        return [known for known in friction if known.name not in twice]

    def check(self, n: int) -> None:
        """UsageError where they are another machine's."""
        if self.last > n:
            text = f"names an effect on axis {self.last}, the base model has {n}"
            raise UsageError(f"{self.where}: {text}: diagnose these logs")

    def columns(self, model: Calibrated) -> list[Array]:
        """Smoothed columns (m, n, k) of gains and free shapes, effect by effect, in each block."""
        n, bench = model.base.n, self._bench(model)
        listed = [(one.axis, _columns(bench, one)) for one in self.listed]
        count = sum(own[0].shape[1] for _, own in listed)
        columns = [np.zeros((len(block.at), n, count)) for block in model.blocks]
        place = 0
        for axis, blocks in listed:
            width = blocks[0].shape[1]
            for whole, own in zip(columns, blocks, strict=True):
                whole[:, axis, place : place + width] = own
            place += width
        return columns

    def parameters(self, model: Calibrated) -> list[Known]:
        """Gains and free shapes, with weak priors: one standard deviation of a gain makes all of
        the axis' torque."""
        known, kinds = list[Known](), kinds_of(model.base, model.base.n)
        squares = sum((part**2).sum(axis=0) for part in self.columns(model))
        rms = np.sqrt(squares / sum(len(block.at) for block in model.blocks))
        for one in self.listed:
            for k, gain in enumerate(one.effect.gains):
                size, torque = float(rms[one.axis, len(known)]), float(model.torque_rms[one.axis])
                # one that does nothing in these runs stays as it was
                idle = size < IDLE * torque
                value = one.gains[k] if idle and one.gains else 0.0
                most = max(abs(value), 1.0) if idle else torque / size
                name, unit = one.parameter(gain.name), kinds[one.axis].unit(gain.unit)
                low = gain.low >= 0.0
                known.append(Known(name, unit, value, most, GROUP, one.axis, bounded=low))
            for shape in one.free:
                name, unit = one.parameter(shape.name), kinds[one.axis].unit(shape.unit)
                wide, value = WEAK * one.deviation[shape.name], one.shape[shape.name]
                known.append(
                    Known(name, unit, value, wide, GROUP, one.axis, bounded=shape.low >= 0)
                )
        return known

    def moved(self, model: Calibrated, values: Mapping[str, float]) -> Extras:
        """The same with gains and shapes from the values of a fit, by the names of parameters."""
        bench, listed = self._bench(model), list[Extra]()
        for one in self.listed:
            shape = {
                name: float(np.clip(values[one.parameter(name)], *ends))
                for name, ends in _ranges(bench, one).items()
            }
            gains = tuple(values[one.parameter(gain.name)] for gain in one.effect.gains)
            listed.append(replace(one, shape={**one.shape, **shape}, gains=gains))
        return replace(self, listed=tuple(listed))

    def apart(self, other: Extras) -> float:
        """Largest difference of a shape from another fit's, in deviations."""
        pairs = zip(self.listed, other.listed, strict=True)
        return max(
            (abs(a.shape[s] - b.shape[s]) / d for a, b in pairs for s, d in a.deviation.items()),
            default=0.0,
        )

    def _bench(self, model: Calibrated) -> Bench:
        effects = {one.effect.id: one.effect for one in self.listed}
        return Bench(model, compiled(model.base.n, effects) if effects else ())


def _columns(bench: Bench, one: Extra) -> list[Array]:
    """Columns (m, k) of the gains of an effect, and its change with each free shape, of each
    block."""
    columns, ranges = [bench.thin(one.effect.id, one.axis, one.shape)], _ranges(bench, one)
    for shape in one.free:
        value, step = one.shape[shape.name], STEP * one.deviation[shape.name]
        ends = np.clip([value + step, value - step], *ranges[shape.name]).tolist()
        sides = [
            bench.thin(one.effect.id, one.axis, {**one.shape, shape.name: end}) for end in ends
        ]
        columns.append(
            [
                ((above - below) @ one.gains / (ends[0] - ends[1]))[:, None]
                for above, below in zip(*sides, strict=True)
            ]
        )
    return [np.hstack(parts) for parts in zip(*columns, strict=True)]


def _ranges(bench: Bench, one: Extra) -> dict[str, tuple[float, float]]:
    """Least and largest value of each free shape, which may have been found on larger runs."""
    ranges = bench.scales.ranges(one.effect.id, one.axis)
    own = {shape.name: (ranges[shape.name], one.shape[shape.name]) for shape in one.free}
    return {name: (min(r.low, value), max(r.high, value)) for name, (r, value) in own.items()}

"""Columns of effects at every sample of the runs: what they follow, and their states."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.hypotheses.compiled import ACCELERATION, TORQUES, Compiled
from flexhex.diagnosis.hypotheses.signals import (
    entering,
    flat,
    late,
    passed_on,
    reported,
    signals_of,
)
from flexhex.diagnosis.hypotheses.swinging import Swung, starts, swung
from flexhex.diagnosis.hypotheses.turning import followed, halved, states_of
from flexhex.diagnosis.regression.calibrate import Calibrated
from flexhex.numeric.rows import alike

Array = NDArray[np.float64]
SWUNG = "swung"
"""The place of effects that swing: accelerations as they feel them."""
SIGNALS = 60_000_000
"""Room for signals of other axes than the one that is asked for [bytes]."""


class Along:
    """What effects follow along the runs of a calibrated base model, and what they make of it.

    across: time goes on from run to run instead of starting anew.
    """

    def __init__(self, model: Calibrated, across: bool = False) -> None:
        self.model, self.across = model, across
        self._signals: dict[bool, list[Array]] = {}
        self._kept: dict[tuple[int, bool, str, int | None, bool], list[Array]] = {}
        self._halves: dict[tuple[object, ...], list[tuple[Array, Array]]] = {}

    def forget(self) -> None:
        """Let go of signals; they are made again when asked for."""
        for kept in (self._signals, self._kept, self._halves, self._torques):
            kept.clear()
        for name in ("found", "_swung"):
            vars(self).pop(name, None)

    def columns(
        self, item: Compiled, axis: int, shape: Mapping[str, float], halvings: int | None = None
    ) -> list[Array]:
        """Columns (samples, k) of an effect on an axis, of each block. halvings: of the samples of
        `Block.fewer`, of all without."""
        columns = self._columns(item, axis, shape, self._place(item), halvings)
        if item.effect.geared == "torque":
            # accelerations follow from them, and noise of a torque has large ones
            length, pairs = (
                1e-3 * 2 ** shape["smooth"],
                zip(columns, self.model.blocks, strict=True),
            )
            columns = [flat(own, length, block.run.motion.ts) for own, block in pairs]
        return columns

    def _columns(
        self,
        item: Compiled,
        axis: int,
        shape: Mapping[str, float],
        place: str,
        halvings: int | None,
    ) -> list[Array]:
        fixed, blocks = fixed_of(item, shape), self.model.blocks
        listed = self._inputs(item, axis, place, halvings)
        states = [alike(np.zeros(1), len(x)) for x in listed]
        if item.along is not None:
            runs, signals = [b.run for b in blocks], self._followed(item, axis)
            first = None
            if item.swings:
                first = starts(item, fixed, axis, [own[0] for own, _ in signals], self._swung)
            states = states_of(
                item, shape, axis, runs, signals, self.across, self.model.base.window, first
            )
            if halvings is not None:
                states = [b.fewer(halvings)(z) for z, b in zip(states, blocks, strict=True)]
        pairs = zip(listed, states, strict=True)
        return [item.columns(x, z, alike(fixed, len(x)))[0] for x, z in pairs]

    def inputs(self, item: Compiled, axis: int, halvings: int | None = None) -> list[Array]:
        """Signals of each block: of the axis (samples, 6), then of all unless the effect is alone;
        the torque is the one that it acts on. halvings: of the samples of `Block.fewer`."""
        return self._inputs(item, axis, self._place(item), halvings)

    def _place(self, item: Compiled) -> str:
        """Where the torque is that an effect acts on; none: as the base model has it."""
        effect, fitted = item.effect, self.model.fitted
        if item.swings:
            return SWUNG
        if effect.line and fitted.lag:
            return effect.line
        found = "fit" if fitted.effects and not (item.moved or effect.loses) else ""
        return "drive" if effect.entered else "link" if effect.geared else found

    def _inputs(self, item: Compiled, axis: int, place: str, halvings: int | None) -> list[Array]:
        # a torque takes longest to make: what does not go with it does without, until it is there
        kind = axis, item.alone, place, halvings, not item.moved or True in self._signals
        if kind not in self._kept:
            self._kept[kind] = self._signals_of(*kind)
            others = [other for other in self._kept if other[0] != axis]
            while others and sum(x.nbytes for own in self._kept.values() for x in own) > SIGNALS:
                del self._kept[others.pop(0)]
        return self._kept[kind]

    def _followed(self, item: Compiled, axis: int) -> list[tuple[Array, Array]]:
        """Signals that the states of an effect follow, and the same with half steps, of each block;
        the last ones are kept, as all shapes of an effect want them."""
        # what drives reported is known, and what they remember of it needs no model
        place = SWUNG if item.swings else _reported(item)
        kind = axis, item.alone, item.by_way, place
        if kind not in self._halves:
            pairs = zip(self._inputs(item, axis, place, None), self.model.blocks, strict=True)
            listed = [
                followed(item, own, b.run.motion, axis, self.model.base.window) for own, b in pairs
            ]
            self._halves = {kind: [(signals, halved(item, signals)) for signals in listed]}
        return self._halves[kind]

    def _signals_of(
        self, axis: int, alone: bool, place: str, halvings: int | None, torques: bool
    ) -> list[Array]:
        if torques not in self._signals:
            self._signals = {torques: signals_of(self.model, self.across, torques)}
        inputs_of_blocks, axes = [], [axis] if alone else [axis, *range(self.model.base.n)]
        for k, signals in enumerate(self._signals[torques]):
            few = np.asarray if halvings is None else self.model.blocks[k].fewer(halvings)
            listed = [few(signals[:, i]) for i in axes]
            if place:
                # all samples are no copy, and others want them as they are
                listed = [own.copy() for own in listed]
            for i, own in zip(axes, listed, strict=True) if place else ():
                if place == SWUNG:
                    own[:, ACCELERATION] = few(self._swung[k].along[:, i])
                else:
                    there = few(self._elsewhere(place)[k][:, i])
                    own[:, TORQUES.stop - there.shape[1] : TORQUES.stop] = there
            inputs_of_blocks.append(np.hstack(listed))
        return inputs_of_blocks

    @cached_property
    def _swung(self) -> list[Swung]:
        return swung(self.model)

    @cached_property
    def _torques(self) -> dict[str, list[Array]]:
        """Torques and their rates in other places than at the joint, made when asked for."""
        return {}

    def _elsewhere(self, place: str) -> list[Array]:
        if place not in self._torques:
            made: Mapping[str, Callable[[Calibrated], list[Array]]] = {
                "fit": lambda model: reported(model, self.found),
                "drive": entering,
                "link": lambda model: passed_on(model, self.found),
            }
            self._torques[place] = made.get(place, partial(late, line=place))(self.model)
        return self._torques[place]

    @cached_property
    def found(self) -> list[Array]:
        """Torque (samples, n) [N m] of each block of the effects that the fit knows, of the torques
        that drives reported."""
        total = [np.zeros_like(block.run.motion.theta) for block in self.model.blocks]
        for known in self.model.fitted.effects:
            item, axis = known.item, known.axis
            listed = self._columns(item, axis, known.shape, _reported(item), None)
            for own, columns in zip(total, listed, strict=True):
                own[:, axis] += columns @ known.gains
        return total


def _reported(item: Compiled) -> str:
    """Where the torque is that a drive reported, if an effect goes with a torque."""
    return "" if item.moved else "drive"


def fixed_of(item: Compiled, shape: Mapping[str, float]) -> Array:
    """Values of an effect's shapes in its order; a zero where it has none."""
    return np.array([shape[s.name] for s in item.effect.shapes] or [0.0])

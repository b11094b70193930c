"""Columns of the library's effects along the runs: raw motion first, then the common window."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.hypotheses.along import Along, fixed_of
from flexhex.diagnosis.hypotheses.compiled import N_SIGNAL, TORQUES, Compiled
from flexhex.diagnosis.hypotheses.misread import Misread
from flexhex.diagnosis.hypotheses.scales import Scales
from flexhex.diagnosis.regression.calibrate import Calibrated
from flexhex.diagnosis.regression.regression import Columns
from flexhex.fmus.common.effects import Shape
from flexhex.numeric.rows import alike

Array = NDArray[np.float64]
LARGER = 2.0
"""Times that a value is clearly larger than another."""
KEPT = 60_000_000
"""Room for columns of effects that are kept for other fits to the same runs [bytes]."""
BEND = 1e-3
"""Change of the phase of a wave [rad] that shows its slope and how it bends."""
STEP = 1e-4
"""Change of a torque, relative to its RMS, that shows how much of it is lost."""


class Bench:
    """Candidate columns beside a calibrated base model."""

    def __init__(
        self, model: Calibrated, effects: Sequence[Compiled], across: bool = False
    ) -> None:
        """across: time goes on from run to run instead of starting anew."""
        self.model, self.n, self.across = model, model.base.n, across
        self.effects = {c.effect.id: c for c in effects}
        self.along = Along(model, across)
        self._shapes: dict[tuple[str, int], list[dict[str, float]]] = {}
        self._grids: dict[tuple[str, int], list[tuple[dict[str, float], Columns]]] = {}
        self._errors: dict[tuple[str, int], tuple[Mapping[str, float], list[Array]]] = {}

    def beside(self, model: Calibrated) -> Bench:
        """The same candidates along other runs."""
        return Bench(model, list(self.effects.values()), self.across)

    @cached_property
    def _misread(self) -> Misread:
        return Misread(self.model)

    def grid(self, name: str, axis: int) -> list[tuple[dict[str, float], Columns]]:
        """Whitened columns of an effect on an axis for all shapes of its grid; kept."""
        if (name, axis) not in self._grids:
            grid = [(shape, self.columns(name, axis, shape)) for shape in self.shapes(name, axis)]
            self._grids[name, axis] = grid
        return self._grids[name, axis]

    def forget(self) -> None:
        """Let go of columns and of the signals that they are made of: they take more memory than
        all else, and are made again when asked for."""
        self.along.forget()
        self._grids.clear()
        self._errors.clear()

    def names(self, axis: int | None) -> list[str]:
        """Ids of the effects that an axis (None: the whole) may have."""
        if axis is None:
            return self.whole
        return [name for name in self.effects if self.shapes(name, axis)]

    @cached_property
    def scales(self) -> Scales:
        """Sizes of the library for each axis."""
        effects = [item.effect for item in self.effects.values()]
        return Scales.of(self.model, effects, self.across)

    def searched(self, name: str, axis: int) -> list[Shape]:
        """Shapes of an effect that may take any value between bounds for an axis."""
        if name not in self.effects:
            return []
        ranges = self.scales.ranges(name, axis)
        return [ranges[shape.name] for shape in self.effects[name].searched]

    def blended(self, name: str, axis: int, shape: Mapping[str, float]) -> dict[str, float] | None:
        """Another shape of an effect of which real ones have a share, the next on its grid that is
        clearly larger; None where there is none."""
        for own in self.searched(name, axis):
            larger = [value for value in own.grid if value >= LARGER * shape[own.name]]
            if own.blended and larger:
                return {**shape, own.name: min(larger)}
        return None

    def shapes(self, name: str, axis: int) -> list[dict[str, float]]:
        """The grid of an effect's shapes on an axis; none where it cannot have the effect."""
        if (name, axis) not in self._shapes:
            self._shapes[name, axis] = self._possible(name, axis)
        return self._shapes[name, axis]

    def _possible(self, name: str, axis: int) -> list[dict[str, float]]:
        if name not in self.effects:
            return [{}]
        effect = (item := self.effects[name]).effect
        if effect.turning and not self.scales.kinds[axis].turns:
            return []
        if effect.geared and not self.model.base.rotors:
            return []
        listed = [self.scales.sized(name, axis, shape) for shape in item.effect.grid]
        own = [shape for shape in listed if self.scales.possible(name, axis, shape)]
        return [shape for shape in own if effect.meets(axis + 1, self.n, shape)]

    def ordered(self, name: str, axis: int) -> tuple[tuple[int, int, float], ...]:
        """Pairs of gains of which the first has at most so many times the size of the second."""
        gains, pairs = self.effects[name].effect.fitted, []
        places = {gain.name: k for k, gain in enumerate(gains)}
        for gain in gains:
            if gain.below:
                more, times = gain.below
                if gain.of == "torque":
                    times *= self.scales.peaks[axis]
                elif gain.of == "inertia":
                    times *= self._misread.inertia(axis)
                pairs.append((places[gain.name], places[more], times))
        return tuple(pairs)

    def columns(self, name: str, axis: int, shape: Mapping[str, float]) -> Columns:
        """Whitened columns of an effect on an axis."""
        thin = self.thin(name, axis, shape)
        if thin[0].ndim == 3:
            rows = [self.model.white(i, [v[:, i] for v in thin]) for i in range(self.n)]
            return Columns(None, np.concatenate(rows))
        return Columns(axis, self.model.white(axis, thin))

    def thin(self, name: str, axis: int, shape: Mapping[str, float]) -> list[Array]:
        """Smoothed columns of each block: (m, k), or (m, n, k) where all axes feel it."""
        if name not in self.effects:
            return [values[name] for values in self._whole]
        item = self.effects[name]
        if item.effect.acts_on == "measurement":
            return self._felt(item, axis, shape)
        if not item.moved or self.across:
            return self._smoothed(item, axis, shape)
        key, blocks = (item.effect, axis, *shape.items()), self.model.blocks
        if all(key in block.made.columns for block in blocks):
            return [block.made.columns[key].astype(np.float64) for block in blocks]
        columns = self._smoothed(item, axis, shape)
        for block, own in zip(blocks, columns, strict=True):
            block.made.add(key, own, KEPT // len(blocks))
        return columns

    def _smoothed(self, item: Compiled, axis: int, shape: Mapping[str, float]) -> list[Array]:
        blocks, order = self.model.blocks, shape.get("order", 0.0)
        halvings = max(block.halvings(axis, order) for block in blocks)
        columns = self.along.columns(item, axis, shape, halvings)
        return [b.fewer(halvings).smooth(own) for b, own in zip(blocks, columns, strict=True)]

    def _felt(self, item: Compiled, axis: int, shape: Mapping[str, float]) -> list[Array]:
        """What an angle error of an axis does to all torques (m, n, k), of each block; the last one
        is kept: it takes two evaluations of the mechanism."""
        if item.effect.geared == "angle":
            return self._meshed(item, axis, shape)
        key = item.effect.id, axis
        if key not in self._errors or self._errors[key][0] != shape:
            columns = self.along.columns(item, axis, shape)
            turned = self._misread.geared if item.effect.geared else self._misread.turned
            self._errors[key] = dict(shape), [turned(k, axis, e) for k, e in enumerate(columns)]
        return self._errors[key][1]

    def _meshed(self, item: Compiled, axis: int, shape: Mapping[str, float]) -> list[Array]:
        """What an error of a gear that goes with the angle of an axis does to all torques."""
        blocks, fixed, order = self.model.blocks, fixed_of(item, shape), shape["order"]
        halvings, felt = max(block.halvings(axis, order) for block in blocks), list[Array]()
        for k, block in enumerate(blocks):
            angle, step, ways = block.run.motion.theta[:, axis], BEND / order, list[Array]()
            for turn in (-step, 0.0, step):
                signals = np.zeros((len(angle), N_SIGNAL))
                signals[:, 0] = angle + turn
                rest = alike(np.zeros(1), len(signals)), alike(fixed, len(signals))
                ways.append(item.columns(signals, *rest)[0])
            before, here, after = ways
            bends = here, (after - before) / (2 * step), (after - 2 * here + before) / step**2
            felt.append(self._misread.meshed(k, axis, bends, halvings))
        return felt

    def taken(self, name: str, axis: int, shape: Mapping[str, float]) -> list[Array]:
        """Share (m,) of a small change of the reported torque that an effect with a gain of one
        takes away, of each block."""
        item, step = self.effects[name], STEP * float(self.model.torque_rms[axis])
        shares, fixed = [], fixed_of(item, shape)
        pairs = zip(self.model.blocks, self.along.inputs(item, axis, 0), strict=True)
        for block, inputs in pairs:
            pushed = np.zeros_like(inputs)
            pushed[:, TORQUES.start] = step
            rest = alike(np.zeros(1), len(inputs)), alike(fixed, len(inputs))
            above, below = (item.columns(inputs + way * pushed, *rest)[0] for way in (1, -1))
            shares.append(block.few.smooth((above - below)[:, 0] / (2 * step)))
        return shares

    @cached_property
    def _whole(self) -> list[Mapping[str, Array]]:
        pairs = zip(self._misread.motions, self.model.blocks, strict=True)
        return [self.model.base.whole(motion, self.model.linear(b.run)) for motion, b in pairs]

    @property
    def whole(self) -> list[str]:
        """Ids of effects that act on the whole mechanism, none of which comes and goes."""
        return [] if self.across else list(self._whole[0])

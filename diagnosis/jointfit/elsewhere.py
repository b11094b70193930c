"""A fit held against runs that it was not made from: the held-out ones."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.hypotheses.candidates import Bench
from flexhex.diagnosis.jointfit.answer import Joint, drifting
from flexhex.diagnosis.jointfit.effects import Part
from flexhex.diagnosis.jointfit.known import about_known, without_stated
from flexhex.diagnosis.runs.blocks import Block

Array = NDArray[np.float64]


class Elsewhere:
    """A fit seen on runs that it was not made from; columns there are computed once."""

    def __init__(self, bench: Bench, blocks: Sequence[Block], drift: Joint | None = None) -> None:
        """drift: what changes from run to run, taken off these too."""
        ours = bench.model
        self.blocks, self.ours = tuple(blocks), bench
        self.there = about_known(ours.base, blocks, ours.fitted, ours.noise, ours.blocks)
        if drift is not None:
            self.there = self.there.less(drifting(self.there, drift))
        self._bench = bench.beside(self.there)
        self._thin: dict[object, list[Array]] = {}

    def without_stated(self) -> Elsewhere:
        """The same of the runs without the torque of what the file states."""
        other = copy(self)
        other.there = without_stated(self.there)
        return other

    def residual(self, parts: Sequence[Part], beta: Sequence[Array], q: Array) -> list[Array]:
        """Torque that base model and effects do not explain there (m, n) [N m] of each block."""
        left = self.there.residual(q)
        for part, gains in zip(parts, beta, strict=True):
            key = (part.id, part.axis, *sorted(part.shape.items()))
            if key not in self._thin:
                self._thin[key] = self._bench.thin(part.id, part.axis or 0, part.shape)
            for k, values in enumerate(self._thin[key]):
                torque = values @ gains
                if torque.ndim == 2:
                    left[k] = left[k] - torque
                else:
                    left[k][:, part.axis or 0] -= torque
        return left

    def updated(self, fit: Joint) -> list[Array]:
        """What a fit leaves there if its base parameters learn from these runs, too, beside what it
        knows of them: how well its effects do, however well the first runs show these."""
        left = self.residual(fit.parts, fit.beta, fit.q)
        there, count = replace(self.there, y=tuple(left)), len(fit.q)
        spread = fit.spread
        G, b = there.regression.gram
        # (G + spread^-1)^-1 b, also where a parameter is sure
        step = spread @ np.linalg.solve(np.eye(count) + G @ spread, b)
        return there.residual(np.asarray(step))


def elsewhere(bench: Bench, blocks: Sequence[Block], drift: Joint | None) -> Elsewhere:
    """A fit seen on other runs, each with those unannounced payloads of the fit's own runs that
    suit it best."""
    model = bench.model
    labels = sorted({block.run.loads for block in model.blocks if model.loads} | {0})
    if len(labels) == 1:
        return Elsewhere(bench, blocks, drift)
    left = list[list[float]]()
    for label in labels:
        seen = Elsewhere(bench, [_with(block, label) for block in blocks], drift)
        pairs = zip(seen.residual((), (), model.regression.q), blocks, strict=True)
        left.append([float(((r[b.usable] / model.torque_rms) ** 2).sum()) for r, b in pairs])
    best = [labels[k] for k in np.argmin(left, axis=0)]
    return Elsewhere(bench, [_with(b, k) for b, k in zip(blocks, best, strict=True)], drift)


def _with(block: Block, loads: int) -> Block:
    return replace(block, run=replace(block.run, loads=loads))

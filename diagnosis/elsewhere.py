"""A fit held against runs that it was not made from: the locked ones."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.answer import Joint, axis_rms, steady
from flexhex.diagnosis.blocks import Block
from flexhex.diagnosis.candidates import Bench
from flexhex.diagnosis.known import about_known
from flexhex.diagnosis.scored import Scored

Array = NDArray[np.float64]


class Elsewhere:
    """A fit seen on runs that it was not made from; columns there are computed once."""

    def __init__(self, bench: Bench, blocks: Sequence[Block], drift: Joint | None = None) -> None:
        """drift: what changes from run to run, taken off these too."""
        ours = bench.made
        self.blocks, self.ours = tuple(blocks), bench
        self.there = about_known(ours.base, blocks, ours.fitted, ours.noise, ours.blocks)
        if drift is not None:
            self.there = steady(self.there, drift)
        self._bench = bench.beside(self.there)
        self._thin: dict[int, list[Array]] = {}

    def residual(self, parts: Sequence[Scored], beta: Sequence[Array], q: Array) -> list[Array]:
        """Torque that base model and effects do not explain there (m, n) [N m] of each block."""
        left = self.there.residual(q)
        for part, gains in zip(parts, beta, strict=True):
            if id(part.columns) not in self._thin:
                thin = self._bench.thin(part.id, part.axis or 0, part.shape)
                self._thin[id(part.columns)] = thin
            for k, values in enumerate(self._thin[id(part.columns)]):
                torque = values @ gains
                if torque.ndim == 2:
                    left[k] = left[k] - torque
                else:
                    left[k][:, part.axis or 0] -= torque
        return left

    def squares(self, parts: Sequence[Scored]) -> Array:
        """Mean squares (n,) of what parts leave there when fitted anew, shapes as they are."""
        regression = self.ours.made.regression
        if parts:
            regression = regression.extended([part.columns for part in parts])
        n_base = len(self.ours.made.known)
        sizes = np.cumsum([part.columns.values.shape[1] for part in parts])[:-1]
        beta = np.split(regression.q[n_base:], sizes) if parts else []
        return axis_rms(self.blocks, self.residual(parts, beta, regression.q[:n_base])) ** 2

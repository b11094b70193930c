"""The base model fitted to the runs: parameters, hysteresis widths, delay of the torque, noise.

What a fit of the base model can explain is no missing effect, so its columns and the tangents of
its nonlinear parameters stand beside every candidate.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from flexhex.diagnosis.basemodels.base import Base, Known
from flexhex.diagnosis.regression.design import Design, Stacked
from flexhex.diagnosis.regression.doubt import doubt
from flexhex.diagnosis.regression.fitted import Fitted
from flexhex.diagnosis.regression.layout import Layout
from flexhex.diagnosis.regression.payloads import Load, carried
from flexhex.diagnosis.regression.regression import Regression
from flexhex.diagnosis.runs.blocks import Block, torque_rms
from flexhex.diagnosis.runs.noise import Noise, alike, calmed, line, rings, settled, whitening
from flexhex.diagnosis.runs.run import Run

Array = NDArray[np.float64]
CLUSTER, CLUSTERS, LEAST_CLUSTER = 1.0, 30, 3.0
"""Length of a cluster [s]; logs that are too short for this many have shorter ones, of at least
this many smoothing windows."""
STRETCHES = 4
"""Folds of an only trajectory."""


@dataclass(frozen=True)
class Calibrated:
    """The base model about its fitted values, ready for candidates.

    y: torque minus nominal (m, n) [N m] and its columns B of each block; a coefficient of one
    is a tolerance of `known`. errors: columns (m, n, k) of each block of errors of
    the geometry, which hardly change with the fit. between: what is asked for repeats; else it
    changes from pass to pass. loads: payloads of the runs. doubt (nb,): how many times less sure
    of each parameter the rows are than noise makes them; none: once. off: mean square of the
    deviations from the machine file, in tolerances, that a fit beside friction finds, 1 or more.
    torque: as reported (m, n) [N m] in the rows of each block.
    """

    base: Base
    blocks: tuple[Block, ...]
    fitted: Fitted
    known: tuple[Known, ...]
    scale: Array
    y: tuple[Array, ...]
    B: tuple[Design, ...]
    errors: tuple[Array, ...]
    noise: Noise
    between: bool = True
    loads: tuple[Load, ...] = ()
    doubt: Array = field(default_factory=lambda: np.ones(0))
    off: float = 1.0
    torque: tuple[Array, ...] = ()

    @cached_property
    def kept(self) -> list[NDArray[np.bool_]]:
        """Rows of each block that count (m,)."""
        return [settled(block.usable) for block in self.blocks]

    @cached_property
    def moving(self) -> list[NDArray[np.bool_]]:
        """Of the rows of each block that count those (m, n) that say something of an axis: it moves
        there, and did in the rows before that whitening takes."""
        pairs = zip(self.blocks, self.kept, strict=True)
        return [settled(block.judged)[kept] for block, kept in pairs]

    @property
    def spacing(self) -> float:
        """Time between two rows [s]."""
        return float(np.median(np.diff(self.blocks[0].at)))

    @cached_property
    def raw(self) -> list[Array]:
        """Torque of the fit (samples, n) [N m] at every sample of each block."""
        modelled = []
        for block in self.blocks:
            motion = block.run.motion
            torque = self.base.torque(motion, self.linear(block.run))
            if len(self.base.curved):
                z, _ = self.base.bend(motion, self.fitted.widths)
                torque = torque + z * self.fitted.gains
            modelled.append(torque)
        return modelled

    @cached_property
    def torque_rms(self) -> Array:
        """RMS of the torque about its mean, of each axis (n,) [N m]."""
        return torque_rms(self.blocks)

    def linear(self, run: Run) -> Array:
        """Linear parameters (n_p,) of the fit with what a run carries."""
        return carried(self.base, self.loads, self.fitted.loads, run, self.fitted.p)

    def places(self, load: Load) -> slice:
        """Where the parameters of a payload stand in `known`."""
        first = self.known.index(load.known[0])
        return slice(first, first + len(load.known))

    @cached_property
    def layout(self) -> Layout:
        """Axis, fold and cluster of every row."""
        order = list(dict.fromkeys(block.run.trajectory for block in self.blocks))
        fold, cluster, length = [], [], self._cluster
        for block, kept in zip(self.blocks, self.kept, strict=True):
            number = order.index(block.run.trajectory)
            second = np.floor(block.at[kept] / length).astype(int)
            first = int(block.at[0] // length)
            cluster.append(1_000_000 * number + second - first)
            span = block.at[-1] - block.at[0] + 1e-9
            part = (STRETCHES * (block.at[kept] - block.at[0]) / span).astype(int)
            fold.append(np.full(len(second), number) if len(order) > 1 else part)
        n, count = self.base.n, len(np.concatenate(cluster))
        _, dense = np.unique(np.concatenate(cluster), return_inverse=True)
        axis = np.repeat(np.arange(n), count)
        twins = np.concatenate([count * i + self._partners() for i in range(n)])
        return Layout(axis, np.tile(np.concatenate(fold), n), np.tile(dense, n), twins)

    @property
    def _cluster(self) -> float:
        """Length of a cluster [s]."""
        spans = {block.run.trajectory: block.at[-1] - block.at[0] for block in self.blocks}
        return float(
            np.clip(sum(spans.values()) / CLUSTERS, LEAST_CLUSTER * self.base.window, CLUSTER)
        )

    def _partners(self) -> NDArray[np.int64]:
        """Row of the next pass at the same instant, of the rows of one axis."""
        starts = np.cumsum([0, *(int(kept.sum()) for kept in self.kept)])
        partner = np.arange(starts[-1])
        for ring in rings(self.blocks):
            first = self.blocks[ring[0]]
            if not all(alike(first, self.blocks[k]) for k in ring[1:]):
                continue
            for a, b in zip(ring, [*ring[1:], ring[0]], strict=True):
                both = self.kept[a] & self.kept[b]
                place = [np.cumsum(self.kept[k]) - 1 + starts[k] for k in (a, b)]
                partner[place[0][both]] = place[1][both]
        return partner

    @cached_property
    def regression(self) -> Regression:
        """All whitened rows, axis by axis."""
        known = np.array([k.wider**-2.0 * np.isfinite(k.tolerance) for k in self.known])
        times = np.append(self.doubt, np.ones(len(known) - len(self.doubt)))
        y, drifting = self.whitened(self.y), not self.between
        return Regression(y, self._white_B, known * times, times, self.layout, drifting=drifting)

    def doubted(self, residual: Sequence[Array]) -> Calibrated:
        """The same, as sure of its parameters as residuals (m, n) [N m] of a fuller one let it."""
        white = np.split(self.whitened(residual), self.base.n)
        cluster = self.layout.cluster[self.layout.rows(0)]
        again = replace(self, doubt=doubt(self._white_B, white, cluster))
        # the columns stay, and take longer than all else
        vars(again)["_white_B"] = self._white_B
        return again

    def less(self, torque: Sequence[Array]) -> Calibrated:
        """The same of the runs without a torque (m, n) [N m] of each block."""
        again = replace(self, y=tuple(y - own for y, own in zip(self.y, torque, strict=True)))
        if "_white_B" in vars(self):
            vars(again)["_white_B"] = self._white_B
        return again

    def as_sure(self, other: Calibrated) -> Calibrated:
        """The same, as sure of its parameters as another of the same runs."""
        return replace(self, doubt=other.doubt, off=other.off)

    def whitened(self, values: Sequence[Array]) -> Array:
        """Whitened rows (R,) of values (m, n) in each block, axis by axis."""
        n = self.base.n
        return np.concatenate([self.white(i, [v[:, i] for v in values])[:, 0] for i in range(n)])

    @cached_property
    def _white_B(self) -> Design:
        pieces = []
        for i in range(self.base.n):
            places = np.unique(np.concatenate([design.places(i) for design in self.B]))
            pieces.append(((places, self.white(i, [d.at(i, places) for d in self.B])),))
        return Design(len(self.known), tuple(pieces))

    @property
    def kept_B(self) -> Stacked:
        """B of the rows that count."""
        return Stacked(self.B, self.kept)

    @property
    def nominal(self) -> Array:
        """Coefficients (nb,) of the machine file's own parameters, the clocks brought together."""
        q = np.zeros(len(self.known))
        late = next(i for i, k in enumerate(self.known) if k.group == "delay")
        q[late] = (self.fitted.delay - self.fitted.expected) / self.scale[late]
        return q

    def forget(self) -> None:
        """Let go of the rows: they take most of the memory, and are made again when asked for."""
        for name in ("regression", "_white_B"):
            vars(self).pop(name, None)

    def white(self, axis: int, values: Sequence[Array]) -> Array:
        """Whitened rows (R_i, k) of an axis from its values (m[, k]) in each block; zeros where it
        rests."""
        slow, runs = self.noise.slow[axis], zip(*self._whitening[axis], self.moving, strict=True)
        parts = [
            calmed(own @ v.reshape(len(v), -1), slow, base, moving[:, axis])
            for v, (own, base, moving) in zip(values, runs, strict=True)
        ]
        return np.concatenate(parts)

    @cached_property
    def _whitening(self) -> list[tuple[list[csr_array], list[Array]]]:
        """See `whitening` and `line`, of each axis, of each block."""
        listed = []
        for i, (a, scale) in enumerate(zip(self.noise.a, self.noise.scale.tolist(), strict=True)):
            weights = [whitening(a, scale, kept) for kept in self.kept]
            listed.append((weights, [line(moving[:, i]) for moving in self.moving]))
        return listed

    def residual(self, q: Array) -> list[Array]:
        """Torque that a fit q does not explain, (m, n) [N m] of each block."""
        return [y - torques(B, q) for y, B in zip(self.y, self.B, strict=True)]


def torques(B: Design, q: Array) -> Array:
    """B q (m, n) of a block."""
    return np.stack([B.times(i, q) for i in range(len(B.pieces))], axis=1)

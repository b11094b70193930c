"""Runs as rows of a regression: smoothed torque and model columns at common instants.

Passes of one trajectory share their instants, so that what repeats can be told from what
does not.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from flexhex.diagnosis.basemodels.base import Base
from flexhex.diagnosis.runs.linear import Linear
from flexhex.diagnosis.runs.rests import PART, moving, sticking
from flexhex.diagnosis.runs.run import Run
from flexhex.diagnosis.runs.smoothing import Few, enough, hann_weights
from flexhex.diagnosis.runs.span import JUDGED, by_trajectory, instants

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
LEAST = 200
"""Rows of a run that a longer window leaves, if there are as many."""


@dataclass
class Made:
    """Smoothed columns that every fit finds alike, by what they are, in half the digits; size:
    theirs [bytes]."""

    columns: dict[Hashable, NDArray[np.float32]] = field(default_factory=dict)
    size: int = 0

    def add(self, key: Hashable, columns: Array, room: int) -> None:
        """Keep some more, if there is room for them."""
        if self.size + columns.nbytes // 2 <= room:
            self.columns[key] = columns.astype(np.float32)
            self.size += self.columns[key].nbytes


@dataclass(frozen=True)
class Block:
    """A run at its instants: at (m,) [s] shared with the other passes, usable (m,); weights (m,
    samples) of the joints' clock; linear: smoothed base columns; moves (m, n): where each axis does
    not rest; every: one of so many samples is enough for columns of effects that have no faster
    waves; drift: torque (m, n) [N m] that changes from run to run and is taken off."""

    run: Run
    at: Array
    weights: csr_array
    linear: Linear
    usable: Mask
    moves: Mask
    every: int = 1
    drift: Array | None = None
    made: Made = field(default_factory=Made, init=False, compare=False)
    _fewer: dict[int, Few] = field(default_factory=dict, init=False, compare=False)

    @property
    def judged(self) -> Mask:
        """Rows (m, n) that say something about the model, for each axis."""
        return self.moves & self.usable[:, None]

    def smooth(self, raw: Array) -> Array:
        """Anything on the joints' clock (samples, ...) at the instants (m, ...)."""
        flat = raw.reshape(len(raw), -1)
        return np.asarray((self.weights @ flat).reshape(-1, *raw.shape[1:]))

    @cached_property
    def angles(self) -> Array:
        """Smoothed angles (m, n)."""
        return self.smooth(self.run.motion.theta)

    @property
    def few(self) -> Few:
        """Samples in windows, as many as a mean needs."""
        return self.fewer(0)

    def fewer(self, halvings: int) -> Few:
        """`few`, twice as many samples for each halving."""
        if halvings not in self._fewer:
            self._fewer[halvings] = Few.of(self.weights, max(self.every >> halvings, 1))
        return self._fewer[halvings]

    def halvings(self, axis: int, order: float) -> int:
        """How many until a wave [1/rad, 1/m] has two samples where its axis is fastest, or all."""
        step, halvings = order * self._fastest[axis] * self.run.motion.ts, 0
        while (every := self.every >> halvings) > 1 and step * every > np.pi:
            halvings += 1
        return halvings

    @cached_property
    def _fastest(self) -> Array:
        return np.asarray(np.abs(self.run.motion.thetad).max(axis=0))


def torque_rms(blocks: Sequence[Block]) -> Array:
    """RMS of the torque about its mean, of each axis (n,) [N m]."""
    counts, means, variances = map(np.array, zip(*(b.run.tau.spread for b in blocks), strict=True))
    share = counts / counts.sum()
    return np.asarray(np.sqrt(share @ (variances + (means - share @ means) ** 2)))


def torque_at(block: Block, window: float, delay: float) -> Array:
    """Reported torque (m, n) [N m] without drift, read `delay` [s] later than the angles' clock."""
    torque, _ = _read(block, window, delay)
    return torque if block.drift is None else torque - block.drift


def torque_rate(block: Block, window: float, delay: float) -> Array:
    """What `torque_at` changes by with its delay (m, n) [N m/s]; zero at the edge of a gap."""
    ts = block.run.tau.ts
    (before, began), (after, ended) = (_read(block, window, delay + step) for step in (-ts, ts))
    return np.where((began & ended)[:, None], (after - before) / (2 * ts), 0.0)


def _read(block: Block, window: float, delay: float) -> tuple[Array, Mask]:
    """The reported torque (m, n) [N m] under the window, and where this is filled (m,)."""
    signal, at = block.run.tau, block.at + block.run.shift + delay
    weights, filled = hann_weights(at, signal.t0, signal.ts, signal.valid, window)
    return np.asarray(weights @ signal.values), filled


def blocks(base: Base, runs: Sequence[Run], spacing: float, least: int = JUDGED) -> list[Block]:
    """Blocks of all runs, trajectory by trajectory.

    Raises LogError when a run is too short for `least` rows at the base's own spacing.
    """
    listed = []
    for passes in by_trajectory(runs):
        at = instants(base, passes, spacing, least)
        listed += [_block(base, run, at) for run in passes]
    usable = [block.usable for block in listed]
    motions = [_smooth(block) for block in listed]
    moves = moving(motions, usable, base.window, spacing)
    paces = np.concatenate([pace[good] for (*_, pace), good in zip(motions, usable, strict=True)])
    pace = np.sqrt((paces**2).mean(axis=0))
    sticks = [b.weights @ sticking(b.run.motion, pace, base.window) > PART for b in listed]
    return [
        replace(block, moves=own & ~stuck)
        for block, own, stuck in zip(listed, moves, sticks, strict=True)
    ]


def _smooth(block: Block) -> tuple[Array, Array, Array]:
    """Angles, rates and accelerations (m, n)."""
    motion = block.run.motion
    return block.angles, block.smooth(motion.thetad), block.smooth(motion.thetadd)


def _block(base: Base, run: Run, at: Array) -> Block:
    motion, tau = run.motion, run.tau
    local = at + run.shift
    weights, filled = hann_weights(local, motion.t0, motion.ts, run.valid, base.window)
    _, known = hann_weights(local, tau.t0, tau.ts, tau.valid, base.window)
    rows = base.rows(motion, weights)
    linear = Linear.of(rows, base.linear)
    moves = np.ones(rows.shape[:2], dtype=bool)
    every = enough(base.window, motion.ts)
    return Block(run, at, weights, linear, filled & known, moves, every)

"""What does not repeat: noise of each axis, measured between the passes of a trajectory."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from flexhex.diagnosis.runs.blocks import Block, torque_rms

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
ORDER = 2
"""Order of the model that whitens an axis."""
FREQUENCIES = 4096
"""Frequencies at which the power of noise is taken."""
ALIKE = 0.02
"""Largest RMS difference of two passes' angles, relative to their motion."""
INEXACT = 0.003
"""Error of the model's forms, relative to the torque's RMS: it repeats, and is not seen between
passes; as white noise, it keeps whitening from trusting what is quieter than the model is good."""


@dataclass(frozen=True)
class Noise:
    """v_k = sum_j a_j v_(k-j) + scale e_k on each axis, at the spacing of the rows.

    a (n, ORDER), scale (n,) [N m]; rms (n,): of v; flat (n,): the scale if it counts as white;
    repeats: measured between passes, not taken from the residual. slow (n, 2): standard deviations
    of a run's own offset and slope, relative to what e_k alone makes of them: 1 or more, as torques
    wander from run to run. correlated (n,): sum of the squares of v's correlations with itself at
    all lags: by so much more the mean product of two passes varies by chance than that of white
    noise.
    """

    a: Array
    scale: Array
    rms: Array
    flat: Array
    repeats: bool
    slow: Array
    correlated: Array

    @staticmethod
    def even(n: int, scale: float) -> Noise:
        """White noise that is assumed, of the same scale [N m] on n axes."""
        size = np.full(n, scale)
        return Noise(np.zeros((n, ORDER)), *(size,) * 3, False, np.ones((n, 2)), np.ones(n))

    @property
    def white(self) -> NDArray[np.bool_]:
        """Axes (n,) whose noise counts as white."""
        return np.asarray((self.a == 0).all(axis=1))

    @property
    def chance(self) -> Array:
        """Standard errors (n,) of sums of squares and products of whitened rows, relative to those
        of white noise."""
        return np.asarray(np.where(self.white, np.sqrt(self.correlated), 1.0))


def unweighted(noise: Noise, axes: NDArray[np.bool_]) -> Noise:
    """Noise that counts as white on some axes (n,).

    Where what is slow is all noise, a torque that the model lacks weighs heavily if it is fast: the
    model follows it as far as it can, and away from what is slow.
    """
    scale = np.where(axes & np.isfinite(noise.flat), noise.flat, noise.scale)
    slow = np.where(axes[:, None], 1.0, noise.slow)
    return replace(noise, a=np.where(axes[:, None], 0.0, noise.a), scale=scale, slow=slow)


def pairs(blocks: Sequence[Block]) -> Iterator[tuple[int, int]]:
    """Neighbouring passes of each trajectory, as places in `blocks`."""
    for ring in rings(blocks):
        yield from pairwise(ring)


def alike(a: Block, b: Block) -> bool:
    """Whether two passes moved alike, so that products between them leave the noise out."""
    first, second = a.angles, b.angles
    both = a.usable & b.usable
    apart, size = (first - second)[both], first[both] - first[both].mean(axis=0)
    return bool((apart**2).mean() < ALIKE**2 * (size**2).mean())


def rings(blocks: Sequence[Block]) -> list[list[int]]:
    """Passes of each trajectory that was run more than once with the same load, as places in
    `blocks`."""
    names = [block.run.repeated for block in blocks]
    groups = [[k for k, n in enumerate(names) if n == name] for name in dict.fromkeys(names)]
    return [group for group in groups if len(group) > 1]


def measured(blocks: Sequence[Block], residual: Sequence[Array]) -> Noise:
    """Noise from residuals (m, n) [N m] of each block."""
    n = residual[0].shape[1]
    white = INEXACT * np.maximum(torque_rms(blocks), np.finfo(float).tiny)
    neighbours = list(pairs(blocks))
    if not neighbours:
        # what is slow may as well be the model's error, and what wanders from run to run, too
        rms = _rms([block.judged for block in blocks], residual)
        # of an axis that rests all the time nothing is known
        flat = np.hypot(np.nan_to_num(rms), white)
        return Noise(np.zeros((n, ORDER)), flat, rms, flat, False, np.ones((n, 2)), np.ones(n))
    traces = [(residual[a] - residual[b]) / np.sqrt(2) for a, b in neighbours]
    masks = [blocks[a].judged & blocks[b].judged for a, b in neighbours]
    a, scale, slow = np.zeros((n, ORDER)), np.zeros(n), np.ones((n, 2))
    for i in range(n):
        own, judged = [trace[:, i] for trace in traces], [mask[:, i] for mask in masks]
        a[i], scale[i] = _regressed(own, judged, float(white[i]))
        slow[i] = _slow(own, judged, a[i], scale[i])
    rms = _rms(masks, traces)
    return Noise(a, scale, rms, np.hypot(rms, white), True, slow, _correlated(a))


def _rms(masks: Sequence[Mask], traces: Sequence[Array]) -> Array:
    """RMS (n,) of traces where masks (m, n) are true; nan where they never are."""
    good, values = np.concatenate(masks), np.concatenate(traces)
    count = good.sum(axis=0)
    square = (values**2 * good).sum(axis=0)
    mean = np.divide(square, count, where=count > 0, out=np.full(len(count), np.nan))
    return np.asarray(np.sqrt(mean))


def _regressed(traces: Sequence[Array], masks: Sequence[Mask], white: float) -> tuple[Array, float]:
    """Coefficients (ORDER,) and scale of one axis' noise with as much white noise [N m] beside."""
    past, now = [], []
    for trace, mask in zip(traces, masks, strict=True):
        good = settled(mask)
        past.append(np.column_stack([np.roll(trace, j) for j in range(1, ORDER + 1)])[good])
        now.append(trace[good])
    X, y = np.concatenate(past), np.concatenate(now)
    a = np.linalg.solve(X.T @ X + max(len(y), 1) * white**2 * np.eye(ORDER), X.T @ y)
    left = ((y - X @ a) ** 2).mean() if len(y) else 0.0
    return np.asarray(a), float(np.sqrt(left + white**2 * (1 + a @ a)))


def _correlated(a: Array) -> Array:
    """Sum of the squared correlations (n,) of noise with these coefficients (n, ORDER): the mean of
    the squared power over its squared mean, over all frequencies."""
    around = np.fft.rfft(np.hstack([np.ones((len(a), 1)), -a]), FREQUENCIES, axis=1)
    power = 1 / np.abs(around) ** 2
    return np.asarray((power**2).mean(axis=1) / power.mean(axis=1) ** 2)


def _slow(traces: Sequence[Array], masks: Sequence[Mask], a: Array, scale: float) -> Array:
    """Standard deviations (2,) of offset and slope of an axis' whitened traces, 1 or more."""
    squares = []
    for trace, mask in zip(traces, masks, strict=True):
        good = settled(mask)
        rows = whitening(a, max(scale, np.finfo(float).tiny), good) @ trace
        squares.append((line(good)[good].T @ rows) ** 2)
    return np.asarray(np.sqrt(np.maximum(np.mean(squares, axis=0), 1.0)))


def line(good: Mask) -> Array:
    """Orthonormal base (R, 2) of a run's offset and slope in those of its rows (R,) that are good,
    zero in the others."""
    rows, base = np.flatnonzero(good), np.zeros((len(good), 2))
    base[rows, 0] = 1.0
    base[rows, 1] = rows - rows.sum() / max(len(rows), 1)
    return np.asarray(base / np.maximum(np.linalg.norm(base, axis=0), np.finfo(float).tiny))


def settled(usable: Mask) -> Mask:
    """Rows (m[, n]) that are usable together with the ORDER rows before them."""
    good = usable.copy()
    for j in range(1, ORDER + 1):
        good[j:] &= usable[:-j]
    good[:ORDER] = False
    return good


def calmed(rows: Array, slow: Array, base: Array, moving: Mask) -> Array:
    """Whitened rows (R, k) of a run, in place, with its offset and slope in units of their own
    noise, and zeros where the axis does not move (R,): there friction carries what it likes; base:
    the `line` of these."""
    if not moving.all():
        rows[~moving] = 0.0
    if (slow != 1).any():
        rows -= base @ ((1 - 1 / slow)[:, None] * (base.T @ rows))
    return rows


def whitening(a: Array, scale: float, kept: Mask) -> csr_array:
    """Weights (R, m) of the rows that are kept: each minus what the rows before it say, in units of
    the noise. One product with them takes far less memory, and so time, than differences do."""
    rows = np.flatnonzero(kept)
    weights = np.tile(np.append(1.0, -a) / scale, len(rows))
    places = (rows[:, None] - np.arange(1 + len(a))).ravel()
    ends = (1 + len(a)) * np.arange(1 + len(rows))
    return csr_array((weights, places, ends), shape=(len(rows), len(kept)))

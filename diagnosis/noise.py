"""What does not repeat: noise of each axis, measured between the passes of a trajectory."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.blocks import Block

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
ORDER = 2
"""Order of the model that whitens an axis."""
ALIKE = 0.02
"""Largest RMS difference of two passes' angles, relative to their motion."""
LEAST = 1e-9
"""Smallest scale [N m]: noiseless data must not divide by zero."""


@dataclass(frozen=True)
class Noise:
    """v_k = sum_j a_j v_(k-j) + scale e_k on each axis, at the spacing of the rows.

    a (n, ORDER), scale (n,) [N m]; floor (n,): RMS of v; repeats: measured between passes, not
    taken from the residual.
    """

    a: Array
    scale: Array
    floor: Array
    repeats: bool

    @property
    def white(self) -> NDArray[np.bool_]:
        """Axes (n,) whose noise counts as white."""
        return np.asarray((self.a == 0).all(axis=1))


def unweighted(noise: Noise, axes: NDArray[np.bool_]) -> Noise:
    """Noise that counts as white on some axes (n,).

    Where what is slow is all noise, a torque that the model lacks weighs heavily if it is fast: the
    model follows it as far as it can, and away from what is slow.
    """
    scale = np.where(axes & np.isfinite(noise.floor), noise.floor, noise.scale)
    return replace(noise, a=np.where(axes[:, None], 0.0, noise.a), scale=scale)


def pairs(blocks: Sequence[Block]) -> Iterator[tuple[int, int]]:
    """Neighbouring passes of each trajectory, as places in `blocks`."""
    for ring in rings(blocks):
        yield from pairwise(ring)


def alike(a: Block, b: Block) -> bool:
    """Whether two passes moved alike, so that products between them leave the noise out."""
    first, second = (block.smooth(block.run.motion.theta) for block in (a, b))
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
    found = list(pairs(blocks))
    if found:
        traces = [(residual[a] - residual[b]) / np.sqrt(2) for a, b in found]
        masks = [blocks[a].usable & blocks[b].usable for a, b in found]
    else:
        traces, masks = list(residual), [block.usable for block in blocks]
    n = traces[0].shape[1]
    a, scale, floor = np.zeros((n, ORDER)), np.zeros(n), np.zeros(n)
    for i in range(n):
        a[i], scale[i] = _regressed([trace[:, i] for trace in traces], masks)
        flat = np.concatenate([t[m, i] for t, m in zip(traces, masks, strict=True)])
        floor[i] = np.sqrt((flat**2).mean()) if len(flat) else np.nan
    return Noise(a, np.maximum(scale, LEAST), floor, bool(found))


def _regressed(traces: Sequence[Array], masks: Sequence[Mask]) -> tuple[Array, float]:
    """Coefficients (ORDER,) and scale of one axis; zeros where there is nothing to fit."""
    past, now = [], []
    for trace, mask in zip(traces, masks, strict=True):
        good = settled(mask)
        past.append(np.column_stack([np.roll(trace, j) for j in range(1, ORDER + 1)])[good])
        now.append(trace[good])
    X, y = np.concatenate(past), np.concatenate(now)
    G = X.T @ X
    if not len(y) or np.linalg.det(G) <= 0:
        return np.zeros(ORDER), 0.0
    a = np.linalg.solve(G + 1e-9 * np.trace(G) * np.eye(ORDER), X.T @ y)
    return a, float(np.sqrt(((y - X @ a) ** 2).mean()))


def settled(usable: Mask) -> Mask:
    """Rows that are usable together with the ORDER rows before them."""
    good = usable.copy()
    for j in range(1, ORDER + 1):
        good[j:] &= usable[:-j]
    good[:ORDER] = False
    return good


def whiten(values: Array, a: Array, scale: float) -> Array:
    """Rows (m, k) minus what the rows before say, in units of the noise."""
    out = values.copy()
    for j, factor in enumerate(a, start=1):
        out[j:] -= factor * values[:-j]
    return np.asarray(out / scale)

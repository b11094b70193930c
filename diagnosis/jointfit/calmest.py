"""How long to smooth a motion that is not quiet: as long as nothing is lost that repeats.

What differs between passes of a motion, noise of the angles and disturbances of the motion itself,
is in the columns: in those of what swings, as a flexible mode does, it may be most of what is
there. A longer window takes it away, and what is fast with it: so it is as long as hardly anything
is lost that repeats and that base model and friction do not explain.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import convolve1d, minimum_filter1d

from flexhex.diagnosis.jointfit.rubbed import with_friction
from flexhex.diagnosis.regression.calibrate import Calibrated
from flexhex.diagnosis.regression.level import freely
from flexhex.diagnosis.regression.window import (
    LONGER,
    SMALLEST_REPEATABLE,
    inertia_of,
    windows,
)
from flexhex.diagnosis.runs.noise import alike, pairs
from flexhex.fmus.filter.equations import hann_window

Array = NDArray[np.float64]
Pairs = Sequence[tuple[int, int]]
QUIET = 0.001
"""Torque of an acceleration that differs between passes, relative to all, which is no matter. With
zero one of 104 cases of development ends otherwise."""
KEPT = 0.9
"""Share of the RMS of the torque that repeats which is left. Any of 0.7 to 0.97 ends the same."""
POINTS = 8
"""Of a window for each row within."""


def calmest(model: Calibrated, usual: float) -> float:
    """The shortest window [s] under which the motion is quiet, or the longest one that takes
    nothing away that matters; that of the fit without repeats. usual: the window [s] for quiet
    angles."""
    longest, inertia = model.base.window, inertia_of(model)
    both = [pair for pair in pairs(model.blocks) if alike(*(model.blocks[k] for k in pair))]
    moved = [inertia * block.smooth(block.run.motion.thetadd) for block in model.blocks]
    rest: list[Array] = []
    for window in windows(model, usual, LONGER):
        if (_apart(model, both, moved, longest) < QUIET * model.torque_rms).all():
            break
        rest = rest or _unexplained(model)
        lost, torque = (_lost(model, both, values, window) for values in (rest, model.torque))
        if (lost > SMALLEST_REPEATABLE * model.torque_rms).any():
            break
        if (torque**2 > (1 - KEPT**2) * model.torque_rms**2).any():
            break
        longest = window
    return longest


def _unexplained(model: Calibrated) -> list[Array]:
    """What base model and friction leave (m, n) [N m] of each block."""
    rubbed = with_friction(model)
    free, _ = freely(rubbed.regression, len(model.base.linear))
    return rubbed.residual(free.q)


def _lost(model: Calibrated, both: Pairs, values: Sequence[Array], window: float) -> Array:
    """RMS (n,) of what repeats of rows (m, n) of each block and a longer window takes away."""
    slow = _smoothed(model, values, window)
    return _mean(model, both, [(v - s) for v, s in zip(values, slow, strict=True)], np.multiply)


def _apart(model: Calibrated, both: Pairs, values: Sequence[Array], window: float) -> Array:
    """RMS (n,) of what does not repeat of rows (m, n) of each block under a longer window."""
    slow = _smoothed(model, values, window)
    return _mean(model, both, slow, lambda a, b: (a - b) ** 2 / 2)


def _mean(
    model: Calibrated,
    both: Pairs,
    values: Sequence[Array],
    square: Callable[[Array, Array], Array],
) -> Array:
    """Root mean square (n,) of two passes, where both move."""
    total, count = np.zeros((2, model.base.n))
    for a, b in both:
        good = np.isfinite(values[a] * values[b]) & model.blocks[a].moves & model.blocks[b].moves
        total += np.sum(square(values[a], values[b]), axis=0, where=good)
        count += good.sum(axis=0)
    return np.asarray(np.sqrt(np.maximum(total, 0.0) / np.maximum(count, 1)))


def _smoothed(model: Calibrated, values: Sequence[Array], window: float) -> list[Array]:
    """Rows (m, n) of each block under a longer window; NaN where it reaches beyond them."""
    if window == model.base.window:
        return list(values)
    weights = _weights(float(np.sqrt(window**2 - model.base.window**2)), model.spacing)
    smooth = []
    for block, own in zip(model.blocks, values, strict=True):
        whole = minimum_filter1d(block.usable, len(weights), mode="constant")[:, None]
        known = np.where(block.usable[:, None], own, 0.0)
        smooth.append(np.where(whole, convolve1d(known, weights, axis=0), np.nan))
    return smooth


def _weights(window: float, spacing: float) -> Array:
    """A Hann window [s] in rows so far apart [s], between which values go in straight lines."""
    half = int(np.ceil(window / 2 / spacing))
    at = np.linspace(-window / 2, window / 2, POINTS * (2 * half + 1))
    apart = np.abs(at / spacing - np.arange(-half, half + 1)[:, None])
    weights = np.maximum(1 - apart, 0.0) @ hann_window(at + window / 2, window)
    return np.asarray(weights / weights.sum())

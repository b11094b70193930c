"""How long to smooth at best: as long as nothing is lost that repeats.

Noise of the angles is in the columns: in those of what swings, as a flexible mode does, it may be
most of what is there. A longer window takes noise away, and what is fast with it: so it is as long
as the torque lets, and what base model and friction leave of it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import convolve1d, minimum_filter1d

from flexhex.diagnosis.jointfit.rubbed import with_friction
from flexhex.diagnosis.regression.calibrate import Calibrated
from flexhex.diagnosis.regression.level import freely
from flexhex.diagnosis.regression.window import LONGER, windows
from flexhex.diagnosis.runs.noise import alike, pairs
from flexhex.fmus.filter.equations import hann_window

Array = NDArray[np.float64]
LOST = 0.002
"""RMS of what repeats and is not explained yet, relative to the torque's, that a longer window may
take away. Of 54 cases of development, halved, one ends wrongly (unknown else), doubled none."""
KEPT = 0.9
"""Share of the RMS of the torque that repeats which it leaves. Any of 0.7 to 0.97 ends the same."""
POINTS = 8
"""Of a window for each row within."""


def calmest(model: Calibrated, usual: float) -> float:
    """The longest window [s] that takes nothing away that matters; that of the fit without repeats,
    or if there is none. usual: the window [s] for quiet angles."""
    longest, rubbed = model.base.window, with_friction(model)
    both = [pair for pair in pairs(model.blocks) if alike(*(model.blocks[k] for k in pair))]
    if not both:
        return longest
    free, _ = freely(rubbed.regression, len(model.base.linear))
    rest = rubbed.residual(free.q)
    for window in windows(model, usual, LONGER):
        left, torque = (
            _lost(model, both, values, window) / model.torque_rms for values in (rest, model.torque)
        )
        if (left > LOST).any() or (torque**2 > 1 - KEPT**2).any():
            break
        longest = window
    return longest


def _lost(
    model: Calibrated, both: Sequence[tuple[int, int]], values: Sequence[Array], window: float
) -> Array:
    """RMS (n,) of what repeats of rows (m, n) of each block and a longer window takes away."""
    weights = _weights(float(np.sqrt(window**2 - model.base.window**2)), model.spacing)
    usable = [block.usable for block in model.blocks]
    known = [np.where(own[:, None], v, 0.0) for v, own in zip(values, usable, strict=True)]
    fast = [v - convolve1d(v, weights, axis=0) for v in known]
    whole = [minimum_filter1d(own, len(weights), mode="constant") for own in usable]
    square, count = np.zeros((2, model.base.n))
    for a, b in both:
        good = model.blocks[a].moves & model.blocks[b].moves & (whole[a] & whole[b])[:, None]
        square += (fast[a] * fast[b] * good).sum(axis=0)
        count += good.sum(axis=0)
    return np.asarray(np.sqrt(np.maximum(square, 0.0) / np.maximum(count, 1)))


def _weights(window: float, spacing: float) -> Array:
    """A Hann window [s] in rows so far apart [s], between which values go in straight lines."""
    half = int(np.ceil(window / 2 / spacing))
    at = np.linspace(-window / 2, window / 2, POINTS * (2 * half + 1))
    apart = np.abs(at / spacing - np.arange(-half, half + 1)[:, None])
    weights = np.maximum(1 - apart, 0.0) @ hann_window(at + window / 2, window)
    return np.asarray(weights / weights.sum())

"""What feedback answers to noise of the angles, as columns beside the base model.

Noise of the angles moves the joints, by the feedback, and is in the reported torque as well as in
the columns. Where a motion is repeated, products between passes leave it out. Where nothing is, it
looks like a mechanism that answers linearly to its own motion: a flexible mode, above all. With n
the noise of an axis, the angles hold S n and the model leaves -M n'', so that

    left = H(s) (fast part of the angles' rates and accelerations)

with a response H that nobody knows. It is fitted freely, band by band. What lies in these columns
is no evidence for an effect: one that is linear in the fast motion of its own axis is not to be
told from feedback then.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.signal import oaconvolve

from flexhex.diagnosis.selection.moments import Moments, Term
from flexhex.diagnosis.selection.rows import Rows
from flexhex.fmus.filter.equations import hann

Array = NDArray[np.float64]
BANDS, WIDER = 6, 2**0.5
"""Bands, from the smoothing window down, and how much slower the next one is."""


def with_feedback(moments: Moments) -> Moments:
    """The model with what feedback may answer on each axis; as it is where passes repeat, or angles
    have no noise."""
    noisy = any(block.run.motion.noise is not None for block in moments.rows.made.blocks)
    if moments.rows.pairs.nnz or not noisy:
        return moments
    for axis in range(moments.rows.n):
        moments = moments.extended(_term(moments, axis))
    return moments


def _bands(rows: Rows, axis: int) -> list[list[Array]]:
    """Rates and accelerations (m, 2) of each block in each band, the fastest first."""
    found = list[list[Array]]()
    blocks, window = rows.made.blocks, rows.made.base.window
    motions = [block.run.motion for block in blocks]
    raw = [np.stack([m.thetad[:, axis], m.thetadd[:, axis]], axis=1) for m in motions]
    faster = raw
    for band in range(1, BANDS + 1):
        slower = [
            _slower(values, window * WIDER**band / m.ts)
            for values, m in zip(raw, motions, strict=True)
        ]
        pairs = zip(blocks, faster, slower, strict=True)
        found.append([block.smooth(fast - slow) for block, fast, slow in pairs])
        faster = slower
    return found


def _slower(values: Array, samples: float) -> Array:
    """Smoothed by a Hann window of so many samples; beyond the ends values stay what they are
    there."""
    weights = hann(max(3, round(samples)))
    half = len(weights) // 2
    padded = np.pad(values, ((half, len(weights) - 1 - half), (0, 0)), mode="edge")
    return np.asarray(oaconvolve(padded, weights[:, None] / weights.sum(), mode="valid", axes=0))


def _term(moments: Moments, axis: int) -> Term:
    """Rates and accelerations in each band; one standard deviation of each coefficient makes as
    much torque as is left."""
    rows = moments.rows
    values = [np.hstack(own) for own in zip(*_bands(rows, axis), strict=True)]
    white = rows.white(axis, values)
    left = rows.white_y[axis] - moments.white(axis, moments.fit(None).q)
    squares = np.maximum((white**2).mean(axis=0), np.finfo(float).tiny)
    return Term({axis: rows.raw(values)}, {axis: white}, squares / (left**2).mean())

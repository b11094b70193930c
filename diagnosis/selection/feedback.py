"""What feedback answers to noise of the angles, as columns beside the base model.

Noise of the angles moves the joints, by the feedback, and is in the reported torque as well as in
the columns. Where a motion is repeated, products between passes leave it out. Where nothing is, it
looks like a mechanism that answers linearly to its own motion: a flexible mode, above all. With n
the noise of an axis, the angles hold S n and the model leaves -M n'', so that

    left = H(s) (fast part of the angles' rates and accelerations)

with a response H that nobody knows, fitted freely, band by band. It competes with every effect of
the axis: one that explains no more than this has no name, and this is in the model instead.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray
from scipy.signal import oaconvolve

from flexhex.diagnosis.selection.bars import form_error
from flexhex.diagnosis.selection.choose import as_good
from flexhex.diagnosis.selection.criteria import Criteria
from flexhex.diagnosis.selection.evidence import together
from flexhex.diagnosis.selection.hypothesis import EffectHypothesis
from flexhex.diagnosis.selection.moments import Moments, Term
from flexhex.diagnosis.selection.rows import Rows
from flexhex.diagnosis.selection.scores import Score
from flexhex.fmus.filter.equations import hann

Array = NDArray[np.float64]
BANDS, WIDER = 6, 2**0.5
"""Bands, from the smoothing window down, and how much slower the next one is."""


def noisy(rows: Rows) -> set[int]:
    """Axes with noise of the angles in the products: all, where nothing is run twice and there is
    some."""
    there = any(block.run.motion.noise is not None for block in rows.model.blocks)
    return {*range(rows.n)} if there and not rows.pairs.nnz else set()


def answers(
    moments: Moments, axes: Iterable[int], score: Score | None, criteria: Criteria
) -> dict[int, Term]:
    """What feedback may answer, on those of these axes on which it explains as much as an effect
    does, with the error of its form; on all of them where there is none."""
    if score is None:
        return {axis: feedback(moments, axis) for axis in axes}
    if not isinstance(score.hypothesis, EffectHypothesis):
        return {}
    terms = {axis: feedback(moments, axis) for axis in {*axes} & {*score.hypothesis.felt}}
    error = form_error(score, criteria)

    def good(term: Term) -> bool:
        gain = together(moments.extended(term), moments, [term])
        return as_good(gain, score.gain, error, criteria)

    return {axis: term for axis, term in terms.items() if good(term)}


def feedback(moments: Moments, axis: int) -> Term:
    """What feedback may answer on an axis: rates and accelerations in each band; one standard
    deviation of each coefficient makes as much torque as a model leaves."""
    rows = moments.rows
    values = [np.hstack(own) for own in zip(*_bands(rows, axis), strict=True)]
    white = rows.white(axis, values)
    left = rows.white_y[axis] - moments.white(axis, moments.fit(None).q)
    squares = np.maximum((white**2).mean(axis=0), np.finfo(float).tiny)
    return Term({axis: rows.raw(values)}, {axis: white}, squares / (left**2).mean())


def _bands(rows: Rows, axis: int) -> list[list[Array]]:
    """Rates and accelerations (m, 2) of each block in each band, the fastest first."""
    bands = list[list[Array]]()
    blocks, window = rows.model.blocks, rows.model.base.window
    motions = [block.run.motion for block in blocks]
    raw = [np.stack([m.thetad[:, axis], m.thetadd[:, axis]], axis=1) for m in motions]
    faster = raw
    for band in range(1, BANDS + 1):
        slower = [
            _slower(values, window * WIDER**band / m.ts)
            for values, m in zip(raw, motions, strict=True)
        ]
        pairs = zip(blocks, faster, slower, strict=True)
        bands.append([block.smooth(fast - slow) for block, fast, slow in pairs])
        faster = slower
    return bands


def _slower(values: Array, samples: float) -> Array:
    """Smoothed by a Hann window of so many samples; beyond the ends values stay what they are
    there."""
    weights = hann(max(3, round(samples)))
    half = len(weights) // 2
    padded = np.pad(values, ((half, len(weights) - 1 - half), (0, 0)), mode="edge")
    return np.asarray(oaconvolve(padded, weights[:, None] / weights.sum(), mode="valid", axes=0))

"""What feedback answers to noise of the angles, as columns beside the base model.

Noise of the angles moves the joints, by the feedback, and is in the reported torque as well as in
the columns. Where a motion is repeated, products between passes leave it out. Where nothing is, it
looks like a mechanism that answers linearly to its own motion: a flexible mode, an elastic joint.
With n the noise of axis j the angles hold S n, and the model leaves -M_ij(theta) n'' on every axis
i, so that

    left_i = M_ij(theta) H_j(s) (fast part of the acceleration of axis j)

with a response H_j that nobody knows, fitted freely, band by band, real and imaginary parts. It
competes with every effect: one that explains no more than this has no name, and this is in the
model instead. Where this makes more torque than all that differs between passes, it is no answer to
noise. It stays in the model, so that no effect is named in its place; an axis without a name
reports it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import reduce

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.runs.blocks import Block
from flexhex.diagnosis.selection.bars import form_error
from flexhex.diagnosis.selection.choose import as_good
from flexhex.diagnosis.selection.criteria import Criteria
from flexhex.diagnosis.selection.evidence import together
from flexhex.diagnosis.selection.hypothesis import EffectHypothesis
from flexhex.diagnosis.selection.moments import Moments, Term
from flexhex.diagnosis.selection.rows import Rows
from flexhex.diagnosis.selection.scores import Score
from flexhex.fmus.filter.equations import hann
from flexhex.numeric.convolved import convolved

Array = NDArray[np.float64]
BANDS, WIDER = 6, 2**0.5
"""Bands, from the smoothing window down, and how much slower the next one is."""


def noisy(rows: Rows) -> bool:
    """Whether noise of the angles is in the products: it is there, no two passes moved alike."""
    there = any(block.run.motion.noise is not None for block in rows.model.blocks)
    return there and not rows.pairs.nnz


def answers(moments: Moments, score: Score | None, criteria: Criteria) -> list[Term]:
    """What feedback may answer, if it explains as much as an effect does, with the error of its
    form, or if there is none."""
    if score is not None and not isinstance(score.hypothesis, EffectHypothesis):
        return []
    terms = feedback(moments)
    if score is None:
        return terms
    gain = together(reduce(Moments.extended, terms, moments), terms)
    return terms if as_good(gain, score.gain, form_error(score, criteria), criteria) else []


def repeating(moments: Moments, terms: Sequence[Term]) -> NDArray[np.bool_]:
    """Axes (n,) on which terms of a model make more torque than what does not repeat between
    passes: that is no answer to noise."""
    rows, q = moments.rows, moments.fit(None).q
    torque = np.zeros((rows.n, len(rows.y[0])))
    for term in terms:
        for axis, raw in term.raw.items():
            torque[axis] += raw @ q[moments.place(term)]
    levelled = [rows.level(axis, own) for axis, own in enumerate(torque)]
    size = [float(own @ own) / max(int(rows.moving[i].sum()), 1) for i, own in enumerate(levelled)]
    return rows.model.noise.repeats & (np.sqrt(size) > rows.model.noise.rms)


def feedback(moments: Moments) -> list[Term]:
    """What feedback may answer to the noise of each axis; one standard deviation of each
    coefficient makes as much torque as a model leaves."""
    rows, q, terms = moments.rows, moments.fit(None).q, list[Term]()
    left = sum(((rows.white_y[i] - moments.white(i, q)) ** 2).mean() for i in range(rows.n))
    length = rows.model.base.window
    columns = [_answers(block, _inertia(rows, block), length) for block in rows.model.blocks]
    for source in range(rows.n):
        values = {i: [own[:, i, source] for own in columns] for i in range(rows.n)}
        felt = {i: v for i, v in values.items() if any(part.any() for part in v)}
        white = {i: rows.white(i, v) for i, v in felt.items()}
        squares = sum((w**2).mean(axis=0) for w in white.values())
        # a column that no row feels, as of an axis that rests, stays out of it with any
        prior = np.where(squares > 0, squares, 1.0) / left
        terms.append(Term({i: rows.raw(v) for i, v in felt.items()}, white, prior))
    return terms


def _inertia(rows: Rows, block: Block) -> Array:
    """M (samples, n, n): torque on each axis for the acceleration of each."""
    base, motion, p = rows.model.base, block.run.motion, rows.model.linear(block.run)

    def torque(accelerated: Array) -> Array:
        moved = replace(motion, thetadd=np.broadcast_to(accelerated, motion.theta.shape))
        moved.solved.update(motion.solved)  # of the same angles
        return base.torque(moved, p)

    still = torque(np.zeros(rows.n))
    return np.stack([torque(unit) - still for unit in np.eye(rows.n)], axis=2)


def _answers(block: Block, inertia: Array, length: float) -> Array:
    """Torques (m, n, n, 2 BANDS) of each axis that accelerates with the rate or the acceleration of
    each in each band, the fastest first."""
    motion = block.run.motion
    raw = np.stack([motion.thetad, motion.thetadd], axis=2)
    faster, bands = raw, list[Array]()
    for band in range(1, BANDS + 1):
        slower = _slower(raw, length * WIDER**band / motion.ts)
        bands.append(block.smooth(inertia[..., None] * (faster - slower)[:, None]))
        faster = slower
    return np.concatenate(bands, axis=3)


def _slower(values: Array, samples: float) -> Array:
    """Smoothed by a Hann window of so many samples; beyond the ends values stay what they are
    there."""
    weights = hann(max(3, round(samples)))
    half, rest = len(weights) // 2, values.ndim - 1
    padded = np.pad(values, ((half, len(weights) - 1 - half), *((0, 0),) * rest), mode="edge")
    return convolved(padded, weights / weights.sum())

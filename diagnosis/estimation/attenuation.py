"""Noise of the angles stands in the columns, too, and makes what goes with accelerations too small.

    B = B_true + sum_j (dB/dthetadd_j) n_j,   E[B^T B] = B_true^T B_true + E

so the estimate is off by -A E q, A its covariance for rows of unit noise [Fuller, Measurement Error
Models, 1987, ch. 1]. That is taken back. n_j is the smoothed second difference of an angle's error:
of white noise, or of the steps of an encoder along a motion like this. The correction is taken to
be known to its own size, which is added to the interval. Products between passes have no such
error, but for steps that come again in the same places.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, eye_array

from flexhex.diagnosis.basemodels.base import Base, Motion
from flexhex.diagnosis.regression.calibrate import Calibrated
from flexhex.diagnosis.regression.regression import Regression
from flexhex.diagnosis.regression.window import curvature
from flexhex.diagnosis.reversals import encoder_step
from flexhex.diagnosis.runs.blocks import Block
from flexhex.numeric.convolved import convolved

Array = NDArray[np.float64]
STATES = 100
"""Instants of a run at which its columns are asked for."""


def taken_back(model: Calibrated, regression: Regression) -> Array:
    """What noise of the angles took from the coefficients (nb,), in units of these."""
    return np.asarray(regression.covariance @ (_noise(model) @ regression.q))


def _noise(model: Calibrated) -> Array:
    """E (nb, nb), of whitened rows."""
    nb, base = len(model.known), model.base
    E, alone = np.zeros((nb, nb)), _alone(model)
    places = np.arange(len(base.linear))
    for block, rows in zip(model.blocks, alone, strict=True):
        motion = block.run.motion
        if motion.noise is None or not motion.derived or not rows.any():
            continue
        columns = np.zeros((nb, len(places)))
        columns[places, places] = 1.0
        for load in model.loads:
            if load.on(block.run):
                columns[model.places(load), list(base.payload)] = np.eye(len(base.payload))
        columns *= model.scale[:, None]
        for axis, noise in enumerate(_accelerations(base, block)):
            squares = _squares(base, block, axis, rows / model.noise.scale**2)
            E += float(noise) * columns @ squares @ columns.T
    return E


def _accelerations(base: Base, block: Block) -> Array:
    """Mean square (n,) of the error of smoothed accelerations: that of white noise, or, where an
    angle comes in steps, what steps make of the same motion."""
    motion = block.run.motion
    assert motion.noise is not None
    step = encoder_step(motion.theta[block.run.valid])
    squares = (motion.noise * curvature(base.window, motion.ts)) ** 2
    window = np.hanning(2 * round(base.window / motion.ts / 2) + 3)[1:-1]
    window, reach = window / window.sum(), len(window) // 2
    for axis in np.flatnonzero(step):
        theta, size = motion.theta[:, [axis]], step[axis]
        smooth = convolved(np.pad(theta, ((reach, reach), (0, 0)), mode="edge"), window)
        error = theta[0] + size * np.round((smooth - theta[0]) / size) - smooth
        bent = block.smooth(np.gradient(np.gradient(error, motion.ts, axis=0), motion.ts, axis=0))
        squares[axis] = float((bent[block.usable] ** 2).mean())
    return squares


def _squares(base: Base, block: Block, axis: int, weights: Array) -> Array:
    """Sum over the rows of a block of the squares (n_p, n_p) of what its columns change by with the
    acceleration of an axis; weights (n,): rows of each axis, times what they count."""
    motion = block.run.motion
    at = np.unique(np.linspace(0, len(motion.theta) - 1, STATES).astype(int))
    theta, still = motion.theta[at], np.zeros((len(at), base.n))
    faster = still.copy()
    faster[:, axis] = step = max(float(np.sqrt((motion.thetadd[:, axis] ** 2).mean())), 1e-12)
    each = csr_array(eye_array(len(at)))
    slow, fast = (base.rows(Motion(0.0, 1.0, theta, still, a), each) for a in (still, faster))
    slope = (fast - slow) / step
    return np.asarray(np.einsum("i,mip,miq->pq", weights / len(at), slope, slope))


def _alone(model: Calibrated) -> list[Array]:
    """How many rows (n,) of each block are their own partners, of each axis."""
    layout, n, counts = model.layout, model.base.n, list[Array]()
    own = (layout.partner == np.arange(len(layout.partner))).reshape(n, -1)
    first = 0
    for kept, block in zip(model.kept, model.blocks, strict=True):
        last, moving = first + int(kept.sum()), block.moves[kept]
        counts.append((own[:, first:last].T & moving).sum(axis=0).astype(float))
        first = last
    return counts

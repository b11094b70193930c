"""States that follow the way of an angle: they turn when the motion does, between two samples."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Motion
from flexhex.diagnosis.hypotheses.compiled import N_SIGNAL, Compiled

Array = NDArray[np.float64]


def followed(item: Compiled, inputs: Array, motion: Motion, axis: int) -> Array:
    """Signals (samples, signals) that states follow: angles without their noise where ways
    count."""
    if not item.by_way:
        return inputs
    signals = inputs.copy()
    signals[:, 0] = motion.steady[:, axis]
    if not item.alone:
        signals[:, N_SIGNAL::N_SIGNAL] = motion.steady
    return signals


def halved(item: Compiled, signals: Array) -> Array:
    """Signals along which states are integrated: with half steps where ways count."""
    if not item.by_way:
        return signals
    finer = np.empty((2 * len(signals) - 1, signals.shape[1]))
    finer[::2], finer[1::2] = signals, (signals[1:] + signals[:-1]) / 2
    return finer


def states_along(
    item: Compiled, state: Array, finer: Array, fixed: Array, motion: Motion, axis: int
) -> Array:
    """States (samples, states) along a block, from a state (states,) with these shapes; finer: see
    `halved`.

    What goes by the way of an angle turns between two samples: so of each sample the mean of half a
    step before and after it, or more of one of them by how much later the motion turned.
    """
    assert item.along is not None
    states = item.along(state, finer, fixed)
    if not item.by_way:
        return states
    before, after, result = states[1:-2:2], states[3::2], states[::2].copy()
    late = motion.turning[1:-1, axis, None]
    result[1:-1] = (0.5 + late) * before + (0.5 - late) * after
    return result

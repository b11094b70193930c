"""States that follow the way of an angle: they turn when the motion does, between two samples."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import convolve1d

from flexhex.diagnosis.basemodels.base import Motion
from flexhex.diagnosis.hypotheses.compiled import ACCELERATION, N_SIGNAL, RATE, Compiled
from flexhex.diagnosis.runs.run import Run
from flexhex.fmus.filter.equations import hann
from flexhex.numeric.rows import alike

Array = NDArray[np.float64]


def followed(item: Compiled, inputs: Array, motion: Motion, axis: int, window: float) -> Array:
    """Signals (samples, signals) that states follow: where ways count, angles without their noise,
    and rates of the axis smoothed over a window [s]: the size of a rate is never that of noise."""
    if not item.by_way:
        return inputs
    signals = inputs.copy()
    signals[:, 0] = motion.steady[:, axis]
    if motion.derived:
        taps = hann(2 * max(round(window / motion.ts / 2), 1))
        signals[:, RATE] = convolve1d(signals[:, RATE], taps, mode="nearest")
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
    step before and after it, or more of one of them by how much later the motion turned. Where an
    encoder shows nothing of a turn, they go evenly to what they are after it: so they turn in its
    middle, and where feedback has to bring the torque to the other side meanwhile, with that.
    """
    assert item.along is not None
    step = motion.ts / (2 if item.by_way else 1)
    states = item.along(state, finer, np.append(fixed, step))
    if not item.by_way:
        return states
    before, after, result = states[1:-2:2], states[3::2], states[::2].copy()
    late = motion.turning[1:-1, axis, None]
    result[1:-1] = (0.5 + late) * before + (0.5 - late) * after
    held = motion.held[axis]
    if len(held.samples):
        share = held.share[:, None]
        turned = (1 - share) * result[held.before] + share * result[held.after]
        result[held.samples] = turned
    return result


def states_of(
    item: Compiled,
    shape: Mapping[str, float],
    axis: int,
    runs: Sequence[Run],
    signals: Sequence[tuple[Array, Array]],
    across: bool,
    window: float,
    first: Sequence[Array] | None = None,
) -> list[Array]:
    """States (samples, states) along each run, each as if it had long moved as it does first or,
    across, from run to run; signals: those that they follow, and the same as `halved`; window: over
    which an acceleration is known [s]; first: states (states,) at the start of each run, if known.

    What happened before or between the runs that are known is taken to have been like the
    next one.
    """
    assert item.along is not None
    fixed = np.array([shape[s.name] for s in item.effect.shapes])
    rest = _rests(item, fixed, runs, signals, window) if first is None else first
    states: dict[int, Array] = {}
    state, now = None, 0.0
    for k in sorted(range(len(runs)), key=lambda k: runs[k].start):
        run, (own, finer) = runs[k], signals[k]
        if state is None or not across:
            state = rest[k]
        if across:
            length = run.motion.ts * len(own)
            for _ in range(round((run.start - now) / length)):
                state = item.along(state, own, np.append(fixed, run.motion.ts))[-1]
            now = run.start + length
        states[k] = states_along(item, state, finer, fixed, run.motion, axis)
        state = states[k][-1]
    return [states[k] for k in range(len(runs))]


def _rests(
    item: Compiled,
    fixed: Array,
    runs: Sequence[Run],
    signals: Sequence[tuple[Array, Array]],
    window: float,
) -> Array:
    """States (runs, states) of what had long moved as each run does first."""
    assert item.start is not None
    begins = np.array([own[0, :N_SIGNAL] for own, _ in signals])
    for k, run in enumerate(runs):
        # an acceleration of one sample is noise
        part = slice(max(round(window / run.motion.ts), 1))
        begins[k, ACCELERATION] = signals[k][0][part, ACCELERATION].mean()
    (rest,) = item.start(begins, alike(fixed if len(fixed) else np.zeros(1), len(begins)))
    return rest

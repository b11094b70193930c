"""Accelerations as a mechanism that swings feels them: what of them repeats, and what came before.

Noise of an angle swings a mode at its own frequency, and so does a start that is not the true one.
Both hide how the motion itself swings it. So those frequencies count at which passes of a motion
have more in common than noise has by chance. What begins at rest rested before. Of a run that
begins in motion, linear prediction says what came before: its waves went on.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Motion
from flexhex.diagnosis.hypotheses.compiled import ACCELERATION, N_SIGNAL, Compiled
from flexhex.diagnosis.regression.calibrate import Calibrated
from flexhex.diagnosis.runs.noise import alike, rings
from flexhex.diagnosis.runs.rests import SLOW
from flexhex.diagnosis.runs.run import Run
from flexhex.numeric.rows import alike as each

Array = NDArray[np.float64]
SEGMENT = 2.0
"""Length [s] of the parts of passes whose spectra are averaged (Welch 1967). In four draws of the
noise of `test_calmest.py` a mode at 9 Hz is found within 2 %; with 1 s within 6 %, with 4 s 4 %."""
CHANCE = 3.0
"""Standard deviations of what two noises have in common by chance. With 2 that mode is where it is
with 3; with 1 and less one at 20 Hz has an interval without it."""


@dataclass(frozen=True)
class Swung:
    """Accelerations (samples, n) of a run, as far as they repeat, and those before it (steps, n),
    so far [s] apart, of which the last is that of the first sample."""

    along: Array
    before: Array
    apart: float


def swung(model: Calibrated) -> list[Swung]:
    """What swings on each axis of each block."""
    listed = [np.ones((2, model.base.n)) for _ in model.blocks]
    for ring in rings(model.blocks):
        passes = [model.blocks[k] for k in ring]
        if all(alike(passes[0], other) for other in passes[1:]):
            kept = _repeating([block.run for block in passes])
            for k in ring:
                listed[k] = kept
    window = model.base.window
    pairs = zip(model.blocks, listed, strict=True)
    return [_swung(block.run, kept, window) for block, kept in pairs]


def starts(
    item: Compiled, fixed: Array, axis: int, firsts: Sequence[Array], runs: Sequence[Swung]
) -> list[Array]:
    """States (states,) at the start of each run, after what came before; firsts: signals there."""
    assert item.start is not None
    assert item.along is not None
    listed = list[Array]()
    for first, run in zip(firsts, runs, strict=True):
        signals = np.repeat(first[None], len(run.before), axis=0)
        signals[:, ACCELERATION] = run.before[:, axis]
        (rest,) = item.start(signals[:1, :N_SIGNAL], each(fixed, 1))
        listed.append(item.along(rest[0], signals, np.append(fixed, run.apart))[-1])
    return listed


def _repeating(passes: Sequence[Run]) -> Array:
    """One for frequencies of accelerations that repeat, zero for others (frequencies, n), from 0 to
    the Nyquist frequency of their samples. A share of a frequency that repeats would make gains
    larger: products between passes leave its noise out already."""
    from scipy.signal import csd  # takes long to load

    first, clocks = passes[0].motion, [run.motion.time - run.shift for run in passes]
    start, end = max(clock[0] for clock in clocks), min(clock[-1] for clock in clocks)
    at = clocks[0][(clocks[0] >= start) & (clocks[0] <= end)]
    seen = [
        np.stack([np.interp(at, clock, own) for own in run.motion.thetadd.T], axis=1)
        for run, clock in zip(passes, clocks, strict=True)
    ]
    length = min(round(SEGMENT / first.ts), len(at))

    def power(a: Array, b: Array) -> Array:
        return np.asarray(csd(a, b, nperseg=length, axis=0)[1].real)

    whole = np.sum([power(own, own) for own in seen], axis=0)
    again = np.sum([power(a, b) for a, b in zip(seen, [*seen[1:], seen[0]], strict=True)], axis=0)
    share = again / np.maximum(whole, np.finfo(float).tiny)
    # overlapping windowed parts count as one and a half times those side by side
    averaged = 1.5 * (len(passes) - 1) * len(at) / length
    return np.where(share > CHANCE / np.sqrt(2 * averaged), 1.0, 0.0)


def _swung(run: Run, kept: Array, window: float) -> Swung:
    """kept: see `_repeating`; window: over which rates and accelerations are known [s]."""
    motion, still, listed = run.motion, _begins_at_rest(run.motion, window), list[Array]()
    way, pace = motion.continued, motion.thetadd
    for i, rested in enumerate(still.tolist()):
        whole = _filtered(way.around(pace[:, i], i, rested), kept[:, i])
        listed.append(whole[: way.lead + len(pace)])
    whole = np.stack(listed, axis=1)
    return Swung(whole[way.lead :], whole[: 1 + way.lead : way.every], way.every * motion.ts)


def _begins_at_rest(motion: Motion, window: float) -> NDArray[np.bool_]:
    """Whether each axis (n,) begins without rate and acceleration, as means over a window [s]."""
    first = slice(max(round(window / motion.ts), 1))
    slow, even = (
        np.abs(v[first].mean(axis=0)) <= SLOW * np.sqrt((v**2).mean(axis=0))
        for v in (motion.thetad, motion.thetadd)
    )
    return np.asarray(slow & even)


def _filtered(values: Array, kept: Array) -> Array:
    """Values (m,) of which these frequencies are kept (frequencies,)."""
    share = np.interp(np.linspace(0, 1, len(values) // 2 + 1), np.linspace(0, 1, len(kept)), kept)
    return np.fft.irfft(share * np.fft.rfft(values), len(values))

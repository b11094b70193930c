"""Orders of the angle that the rows can show, and those of them at which most is left."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.fft import next_fast_len, rfft

from flexhex.diagnosis.hypotheses.scales import PERIODS
from flexhex.diagnosis.selection.rows import Rows
from flexhex.fmus.common.effects import Effect

Array = NDArray[np.float64]
Index = NDArray[np.int32]
SHOWN = 50
"""Places, each with a row that shows a wave, that are needed to tell it: the smoothing window
averages a wave out where the axis is fast. Waves, too, that are needed to say how large chance
makes one of them: of fewer the median is hardly free of the largest."""
FINER, BINS = 4, 4
"""Points of the spectrum between two orders that the stroke tells apart; bins of the angle in the
shortest period."""
TRIED, ANEW = 30, 8
"""Peaks that are tried in full, at first and beside each effect that was found. About twice as many
of them gave the same answers in 63 of 65 cases of the study with waves, in one a worse one and in
one an error that was mended since."""
HARMONIC, OVERTONES = 0.05, 5
"""Distance from a whole multiple of another order within which one is its harmonic; the highest
multiple that is tried of a wave that was found, on any axis."""


def fundamentals(orders: Sequence[float]) -> list[float]:
    """Orders of which the others are harmonics, the lowest first."""
    lowest = list[float]()
    for order in sorted(orders):
        if fundamental_of(order, lowest) is None:
            lowest.append(order)
    return lowest


def fundamental_of(order: float, lowest: Sequence[float]) -> float | None:
    """The one of some orders that another one is a harmonic of."""
    return next((f for f in lowest if abs(order / f - round(order / f)) < HARMONIC), None)


@dataclass(frozen=True)
class Orders:
    """Orders [1/rad] in their order; how many there are to choose from, which the stroke tells
    apart; places of those whose amplitude is larger than that of the orders beside them."""

    orders: tuple[float, ...]
    choices: int
    peaks: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class Octave:
    """An octave of orders, from `first` to `end` of those in `Waves`: the bin of the angle of each
    of the rows (R,), of `count`, what the smoothing window leaves there of such a wave, and both
    summed over the bins (count,): squares, and how much noise of one size makes of the
    amplitude."""

    first: int
    end: int
    bins: Index
    shares: Array
    filled: Array
    noise: float


@dataclass(frozen=True, eq=False)
class Waves:
    """What the rows of an axis can show of waves over its angle, whatever a model leaves: orders
    (k,) [1/rad] and the octaves among them."""

    orders: Array
    octaves: tuple[Octave, ...]


def waves(rows: Rows, axis: int) -> Waves:
    """All orders of which the rows of an axis show anything."""
    window = rows.model.base.window
    angle, rate = rows.angles[:, axis], np.abs(rows.rates[:, axis])
    stroke = float(np.ptp(angle))
    low = 2 * np.pi * PERIODS / stroke
    slow = np.sort(rate)[min(SHOWN, len(rate) - 1)]
    high = max(2 * np.pi / max(slow * window, 1e-9 * stroke), 2 * low)
    finest = min(np.ceil(BINS * stroke * high / (2 * np.pi)), len(angle) * BINS)
    place, coarsest = (angle - angle.min()) / stroke, min(SHOWN**2, finest)
    orders = 2 * np.pi / (FINER * stroke) * np.arange(FINER * int(finest) // 2 + 1.0)
    octaves = list[Octave]()
    for octave in range(int(np.ceil(np.log2(high / low)))):
        first = low * 2.0**octave
        a, b = np.searchsorted(orders, (first, min(2 * first, high))).tolist()
        # twice BINS in the shortest period of this octave, 1 / (2 first)
        wanted = 4 * BINS * stroke * first / (2 * np.pi)
        count = next_fast_len(int(np.clip(wanted, coarsest, finest)), real=True)
        bins = np.minimum(place * count, count - 1).astype(np.int32)
        shares = smoothed(2**0.5 * first * rate * window / (2 * np.pi))
        filled = np.asarray(np.bincount(bins, shares**2, count), dtype=float)
        if np.minimum(filled, 1.0).sum() < SHOWN:
            break
        # beside noise of one size in all rows
        noise = float(np.linalg.norm(filled**0.5 / np.maximum(filled, 1.0)))
        octaves.append(Octave(a, b, bins, shares, filled, noise))
    return Waves(orders, tuple(octaves))


def by_size(rows: Rows, axis: int, effect: Effect, left: Array) -> list[Array]:
    """What a model leaves of an axis' torque, left (R,), times what waves of an effect go with, so
    that their sign stays the same at an angle: nothing, the torque, or for an error of a gear one
    residual with the torque and one with the square of the rate."""
    if effect.acts_on == "torque":
        return [left]
    pairs = zip(rows.model.blocks, rows.model.raw, strict=True)
    listed = [left * rows.raw([block.smooth(torque[:, axis]) for block, torque in pairs])]
    return [*listed, left * rows.rates[:, axis] ** 2] if effect.geared else listed


def promising_orders(shown: Waves, listed: Sequence[Array], most: int) -> Orders:
    """The orders at which residuals of an axis, listed (R,) each, have their largest peaks, at most
    so many of all together, and those beside them."""
    orders, clear = shown.orders, np.zeros((len(listed), len(shown.orders)))
    for own, (k, left) in product(shown.octaves, enumerate(listed)):
        clear[k, own.first : own.end] = _spectrum(own, left)
    there = np.flatnonzero(clear.any(axis=0))
    chosen = [_peaks(each, there, most // len(listed)) for each in clear]
    peaks = np.unique(np.concatenate(chosen))
    best = np.intersect1d(np.concatenate([peaks - 1, peaks, peaks + 1]), there)
    first = np.flatnonzero(np.isin(best, peaks))
    return Orders(tuple(orders[best].tolist()), -(-len(there) // FINER), tuple(first.tolist()))


def stands_out(shown: Waves, listed: Sequence[Array], order: float) -> bool:
    """Whether a wave is larger in one of these residuals than chance makes the largest of its
    octave: of K waves that are alike, squares fall off exponentially, and one beyond 2 ln K of
    their mean is there once in K times. The mean is that of their median. Few waves say nothing of
    each other.
    """
    place = int(np.searchsorted(shown.orders, order))
    for own in shown.octaves:
        count = (own.end - own.first) // FINER
        if not own.first <= place < own.end or count < SHOWN:
            continue
        near = slice(max(place - own.first - FINER, 0), place - own.first + FINER)
        squares = [_spectrum(own, left) ** 2 for left in listed]
        most = [2 * np.log(count) * np.median(each) / np.log(2) for each in squares]
        return any(each[near].max() > least for each, least in zip(squares, most, strict=True))
    return True


def _spectrum(own: Octave, left: Array) -> Array:
    """Amplitudes of the waves of an octave in a residual (R,), relative to those of noise."""
    count = len(own.filled)
    level = np.bincount(own.bins, own.shares * left, count) / np.maximum(own.filled, 1.0)
    return np.asarray(np.abs(rfft(level, FINER * count)[own.first : own.end]) / own.noise)


def _peaks(clear: Array, there: NDArray[np.intp], most: int) -> NDArray[np.intp]:
    """Places of the largest peaks of a spectrum, of those that are `there`."""
    around = np.maximum(clear[there - 1], np.append(clear, 0.0)[there + 1])
    peaks = there[clear[there] >= around]
    return np.asarray(peaks[np.argsort(-clear[peaks])[:most]])


def smoothed(periods: Array) -> Array:
    """Share of a wave's amplitude that a Hann window with so many periods leaves."""
    return np.asarray(np.sinc(periods) + (np.sinc(periods - 1) + np.sinc(periods + 1)) / 2)

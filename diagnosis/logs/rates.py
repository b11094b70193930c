"""Whether measured rates and accelerations are better than differences of the angles.

A channel is used where it goes with the angles, and its noise makes less of an acceleration under
the window of a fit than theirs does. One that is late, filtered, of another size or another axis
would bend what is fitted.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise, starmap

import numpy as np

from flexhex.diagnosis import stencils
from flexhex.diagnosis.kinds import ROTARY, Kinds
from flexhex.diagnosis.logs.log import Array, Channel, Finding, Mask
from flexhex.diagnosis.logs.units import MOVING
from flexhex.diagnosis.reversals import angle_noise
from flexhex.fmus.filter.equations import hann

WINDOW, LEAST = 0.0105, 16
"""Of a fit: seconds, and samples at least."""
LONGER, FEWEST = 4, 4
"""Windows under which channel and angles are compared; how often as many samples there must be."""
OFF, NOISES = 0.02, 3.0
"""Relative difference, and deviations of the noise beside it, within which they go together."""
ORDER = {"thetad": 1, "thetadd": 2}
TITLES = {"thetad": "rates", "thetadd": "accelerations"}


@dataclass(frozen=True)
class _Pair:
    """A channel (samples, n) of one axis' derivative and the same of the angles, smoothed alike;
    noise (n,): deviation of their difference."""

    seen: Array
    derived: Array
    noise: Array
    good: Mask


def judged_rates(
    where: str, channels: Mapping[str, Channel], kinds: Kinds
) -> tuple[frozenset[str], list[Finding]]:
    """Channels of rates and accelerations that are no better than differences of the angles, and
    what is said of each."""
    kept, notes, angle = dict(channels), list[Finding](), channels["theta"]
    for name in ("thetad", "thetadd"):
        if name not in kept:
            continue
        bad = _bad(name, angle, kept[name], kinds)
        source = "thetad" if name == "thetadd" and "thetad" in kept else "theta"
        if not bad:
            times = _noisier(name, kept[name], kept[source], ORDER.get(source, 0), angle)
            what = f"{times:.2g} times the noise that differences of {source} have"
            bad = f"{name} has {what}" if times >= 1 else ""
            if not bad:
                text = f"{TITLES[name]} are those of {name}: {what}"
                notes.append(Finding("rates", where, text, True))
        if bad:
            text = f"{bad}: not used, {TITLES[name]} are differences of {source}"
            notes.append(Finding("rates", where, text, False))
            del kept[name]
    return frozenset(channels) - frozenset(kept), notes


def _noisier(name: str, seen: Channel, other: Channel, order: int, angle: Channel) -> float:
    """Noise of an acceleration from a channel over that from another one, of the derivative
    `order` of the angles, on the axis where this is largest."""
    ts, window = max(angle.ts, 1e-3), max(WINDOW, LEAST * angle.ts)
    own = angle_noise(seen.values) * _gain(2 - ORDER[name], ts, window)
    theirs = angle_noise(other.values) * _gain(2 - order, ts, window)
    tiny = np.finfo(float).tiny
    return float((own / np.maximum(theirs, tiny))[own > 0].max(initial=0.0))


def _gain(order: int, ts: float, window: float) -> float:
    """What a derivative of white noise, sampled every ts, has left under a Hann window."""
    size = (np.sqrt(1.5), np.sqrt(2.0) * np.pi, 2.0 * np.sqrt(2.0) * np.pi**2)[order]
    return float(size * np.sqrt(ts / window) / window**order)


def _bad(name: str, angle: Channel, seen: Channel, kinds: Kinds) -> str:
    """How a channel does not go with the angles, or nothing."""
    if seen.width != angle.width:
        return f"{name} has {seen.width} axes, theta {angle.width}"
    pair = _pair(angle, seen, ORDER[name])
    if pair is None:
        return f"{name} is too short beside theta"
    other = pair.seen - pair.derived
    size, apart = (np.sqrt((v[pair.good] ** 2).mean(axis=0)) for v in (pair.derived, other))
    wrong = (apart > OFF * size + NOISES * pair.noise) & (size > NOISES * pair.noise)
    if not wrong.any():
        return ""
    axis = int(np.argmax(np.where(wrong, apart / np.maximum(size, np.finfo(float).tiny), 0.0)))
    kind = (*kinds, *(ROTARY,) * angle.width)[axis]
    return _described(name, pair, axis, angle.ts, MOVING[name][kind])


def _described(name: str, pair: _Pair, axis: int, ts: float, units: Mapping[str, float]) -> str:
    """In which way it does not."""
    seen, derived = pair.seen[:, axis], pair.derived[:, axis]
    faster = np.gradient(derived, ts)
    A = np.column_stack([derived, -faster, np.ones_like(derived)])[pair.good]
    coefficients = np.linalg.lstsq(A, seen[pair.good], rcond=None)[0]
    left = seen[pair.good] - A @ coefficients
    channel, of = f"{name}[{axis + 1}]", "rate" if name == "thetad" else "acceleration"
    if (left**2).mean() > 0.25 * (derived[pair.good] ** 2).mean():
        return f"{channel} does not go with theta[{axis + 1}]: another axis?"
    if abs(coefficients[0] - 1) > OFF:
        unit = next((u for u, f in units.items() if abs(coefficients[0] * f - 1) < OFF), "")
        plain = next(u for u, f in units.items() if f == 1.0)
        hint = f": is it in {unit} (--unit '{name}={unit} not {plain}')?" if unit else ""
        return f"{channel} is {coefficients[0]:.4g} times the {of} of theta[{axis + 1}]{hint}"
    if abs(coefficients[1]) * np.std(faster) > np.abs(coefficients[2]):
        way = "late" if coefficients[1] > 0 else "early"
        return f"{channel} comes {1e3 * abs(coefficients[1]):.2g} ms {way} beside theta[{axis + 1}]"
    return f"{channel} is off the {of} of theta[{axis + 1}] by {coefficients[2]:.2g}"


def _pair(angle: Channel, seen: Channel, order: int) -> _Pair | None:
    """Both under a window, in the longest stretch without a break."""
    edges = [0, *(index for index, _ in angle.breaks), len(angle.values)]
    part = max(starmap(slice, pairwise(edges)), key=_length)
    theta, time, ts = angle.values[part], angle.time[part], angle.ts
    points = LONGER * max(LEAST, round(WINDOW / ts))
    if len(theta) < FEWEST * points:
        return None
    at = np.column_stack([np.interp(time, seen.time, v) for v in seen.values.T])
    valid = angle.valid[part] & (np.interp(time, seen.time, seen.valid) > 0.999)
    valid &= (time >= seen.time[0]) & (time <= seen.time[-1])
    weights = hann(points)[1:]  # symmetric about its middle
    smooth = [_smoothed(v, weights) for v in (at, theta)]
    reach = points // 2 + 3
    good = np.convolve(~valid, np.ones(2 * reach + 1), "same") < 0.5
    good[:reach] = good[-reach:] = False
    if good.sum() < points:
        return None
    derived = _derived(smooth[1], ts, order)
    window = points * ts
    noise = np.hypot(
        angle_noise(at) * _gain(0, ts, window), angle_noise(theta) * _gain(order, ts, window)
    )
    return _Pair(smooth[0], derived, noise, good)


def _length(part: slice) -> int:
    return int(part.stop - part.start)


def _smoothed(values: Array, weights: Array) -> Array:
    return np.column_stack([np.convolve(v, weights, "same") for v in values.T])


def _derived(theta: Array, ts: float, order: int) -> Array:
    """Differences (samples, n); those at the ends are not good."""
    derived = stencils.first(theta, ts) if order == 1 else stencils.second(theta, ts)
    return np.pad(derived, ((stencils.ENDS, stencils.ENDS), (0, 0)), mode="edge")

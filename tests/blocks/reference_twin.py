"""The reference in plain NumPy and whole numbers: setpoints, moves, triangle, sines."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Motion = tuple[Array, Array, Array]
MASK = 2**64 - 1


def splitmix64(seed: int, count: int) -> list[int]:
    """First numbers of the generator as Vigna's splitmix64.c states it, with running state."""
    numbers, x = [], seed
    for _ in range(count):
        x = (x + 0x9E3779B97F4A7C15) & MASK
        z = x
        z = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) & MASK
        z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & MASK
        numbers.append(z ^ (z >> 31))
    return numbers


def setpoints(seed: int, amplitude: float, moves: int) -> Array:
    """(moves + 1, 6): zero, random points within +-amplitude [rad], zero again."""
    drawn = [(x >> 11) / 2**53 for x in splitmix64(seed, 6 * (moves - 1))]
    points = amplitude * (2 * np.array(drawn).reshape(-1, 6) - 1)
    zero = np.zeros((1, 6))
    return np.concatenate([zero, points, zero])


def from_jerks(t: Array, jerks: Sequence[tuple[float, float]]) -> Motion:
    """Motion from rest at zero under pieces of (length [s], jerk [rad/s3]), at times t [s]."""
    pieces = [(length, 0.0, jerk) for length, jerk in jerks]
    return _pieces(t, pieces, carry_acceleration=True)


def from_accelerations(t: Array, steps: Sequence[tuple[float, float]]) -> Motion:
    """Motion from rest at zero under pieces of (length [s], acceleration [rad/s2])."""
    return _pieces(t, [(length, a, 0.0) for length, a in steps], carry_acceleration=False)


def _pieces(
    t: Array, pieces: Sequence[tuple[float, float, float]], carry_acceleration: bool
) -> Motion:
    starts = np.cumsum([0.0] + [length for length, _, _ in pieces])
    out = np.zeros((3, len(t)))
    r = v = a = 0.0
    for (begin, end), (length, acceleration, jerk) in zip(pairwise(starts), pieces, strict=True):
        a = a if carry_acceleration else acceleration
        inside = (t >= begin) & (t < end)
        s = t[inside] - begin
        out[:, inside] = (
            r + v * s + a * s**2 / 2 + jerk * s**3 / 6,
            v + a * s + jerk * s**2 / 2,
            a + jerk * s,
        )
        r += v * length + a * length**2 / 2 + jerk * length**3 / 6
        v += a * length + jerk * length**2 / 2
        a += jerk * length
    out[0, t >= starts[-1]] = r
    return out[0], out[1], out[2]


def random_motion(t: Array, points: Array, period: float, move: float) -> Motion:
    """(len(t), 6) each: from setpoint to setpoint, acceleration as one rise, fall, rise."""
    unit_jerk = 32 / move**3
    share = [(move / 4, unit_jerk), (move / 2, -unit_jerk), (move / 4, unit_jerk)]
    out = np.zeros((3, len(t), 6))
    for k, (begin, end) in enumerate(pairwise(points)):
        inside = (t >= k * period - 1e-9) & (t < (k + 1) * period - 1e-9)
        s = from_jerks(t[inside] - k * period, share)
        out[:, inside] = np.array(s)[:, :, None] * (end - begin)
        out[0, inside] += begin
    return out[0], out[1], out[2]


def triangle_motion(
    t: Array, cycles: int, amplitude: float, speed: float, rounding: float
) -> Motion:
    """One joint: start, cycles of coasting and turning, stop, as accelerations in a row."""
    corner = speed / rounding
    flank = amplitude / speed - corner / 2  # from a zero to the next corner
    to_peak = (flank - corner / 2, 0.0)  # the start has covered corner / 2 of the flank
    turn = [(2 * corner, -rounding), (2 * flank, 0.0), (2 * corner, rounding)]
    steps = [(corner, rounding), to_peak]
    for k in range(cycles):
        steps += [*turn, (2 * flank, 0.0) if k < cycles - 1 else to_peak]
    return from_accelerations(t, [*steps, (corner, -rounding)])


def faded(t: Array, duration: float, fade: float, wave: Array) -> Array:
    """wave (len(t), 6) within the envelope 10 u^3 - 15 u^4 + 6 u^5 at both ends."""
    u = np.clip(np.minimum(t, duration - t) / fade, 0, 1)
    return np.asarray((10 * u**3 - 15 * u**4 + 6 * u**5)[:, None] * wave)

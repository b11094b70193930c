"""How steep a user's torque is: what jumps, or nearly so, no plant can integrate in its steps."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from flexhex.fmus.common.effects.traced import NAMES

Array = NDArray[np.float64]
POINTS, PARTS, TIMES = 2001, 20, 7
"""Points of a line, parts into which its steepest cell is then cut, and how often: a jump is seen
within 1e-9 of the line."""
BESIDE = 4
"""Random values of the other signals at which a line is drawn, beside zeros."""


def steepest(
    made: ca.Function, gains: Sequence[float], signal: str, half: float
) -> tuple[float, float]:
    """Largest slope of the torque of these gains over a signal from -half to half, and where.

    made: of `OwnEffect.function`; all axes move alike.
    """
    place, rng = NAMES.index(signal), np.random.default_rng(2)
    others = [np.zeros(len(NAMES)), *(0.3 * rng.standard_normal((BESIDE, len(NAMES))))]
    found = (0.0, 0.0)
    for beside in others:
        found = max(found, _along(_line(made, gains, place, beside), -half, half))
    return found


def _line(
    made: ca.Function, gains: Sequence[float], place: int, beside: Array
) -> Callable[[Array], Array]:
    repeats = made.numel_in(0) // len(NAMES)

    def torque(values: Array) -> Array:
        signals = np.tile(beside, (len(values), 1))
        signals[:, place] = values
        columns = made(np.tile(signals, (1, repeats)).T).full()
        return np.asarray(np.asarray(gains) @ columns)

    return torque


def _along(torque: Callable[[Array], Array], low: float, high: float) -> tuple[float, float]:
    """Largest slope and its place: the cell of the largest difference, cut again and again."""
    best, points = (0.0, low), POINTS
    for _ in range(TIMES):
        values = np.linspace(low, high, points)
        change = np.abs(np.diff(torque(values)))
        k = int(np.argmax(np.nan_to_num(change)))
        slope = float(change[k] / (values[k + 1] - values[k]))
        best = max(best, (slope, float(values[k])))
        low, high, points = values[k], values[k + 1], PARTS + 1
    return best

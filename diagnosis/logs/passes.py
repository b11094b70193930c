"""Passes of one trajectory whose torques cannot both be right: another unit, or another sign.

tau_b(t) = factor tau_a(t) + offset       least squares, each axis by itself
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flexhex.diagnosis.kinds import axes_named
from flexhex.diagnosis.logs.log import COARSE, Array, Finding, Log

OTHER_UNIT = 20.0
"""Ratio of two passes' torques that no machine makes, but another unit does."""
TURNED, SAME = 0.2, 0.05
"""Largest distance from -1 of the factor between two passes, and largest share of the torque's mean
square that the factor leaves, from which one has the other sign. What is carried adds to a torque,
and turns neither friction nor inertia."""


def contradictions(group: Sequence[Log], logs: Sequence[Log]) -> list[Finding]:
    """What passes of one trajectory (group, aligned by their `shift`) say against each other; of
    two that differ in size the one that differs more from all logs."""
    return [*_other_sizes(group, logs), *_other_signs(group)]


def _other_sizes(group: Sequence[Log], logs: Sequence[Log]) -> list[Finding]:
    sizes = [_size(log) for log in group]
    least, most = min(sizes), max(sizes)
    if most <= OTHER_UNIT * least:
        return []
    usual = float(np.median([_size(log) for log in logs]))
    odd, other = (most, least) if most * least >= usual**2 else (least, most)
    where, beside = (group[sizes.index(size)].name for size in (odd, other))
    text = f"torques are {odd / other:.3g} times those of {beside}, of the same motion"
    return [Finding("passes", where, f"{text}: another unit?", False)]


def _other_signs(group: Sequence[Log]) -> list[Finding]:
    against = [[_turned(a, b) for b in group] for a in group]
    count = [sum(bool(axes) for axes in row) for row in against]
    if not any(count):
        return []
    # friction takes up work on any way: of two the one that gave it up is wrong
    odd = max(range(len(group)), key=lambda k: (count[k], -_work(group[k])))
    other = next(k for k, axes in enumerate(against[odd]) if axes)
    axes = axes_named(against[odd][other])
    text = f"the torque of {axes} is -1 times that of {group[other].name}, of the same motion"
    return [Finding("passes", group[odd].name, f"{text}: another sign?", False)]


def _turned(a: Log, b: Log) -> list[int]:
    """Axes, from 0, on which the torque of b is that of a with the other sign."""
    one, two = a["tau_meas"], b["tau_meas"]
    if a is b or one.width != two.width:
        return []
    first, second = (
        c.time[0] - log.shift + COARSE * np.arange(len(c.coarse)) for c, log in ((one, a), (two, b))
    )
    inside = (first >= second[0]) & (first <= second[-1])
    if inside.sum() < 2:
        return []
    turned = []
    for axis in range(one.width):
        x = one.coarse[inside, axis]
        y = np.interp(first[inside], second, two.coarse[:, axis])
        x, y = x - x.mean(), y - y.mean()
        # squares, as a torque may be the same number all the time
        xx, yy, xy = x @ x, y @ y, x @ y
        if abs(xy + xx) < TURNED * xx and xy**2 > (1 - SAME) * xx * yy:
            turned.append(axis)
    return turned


def _size(log: Log) -> float:
    return max(float(log.tau.std()), 1e-300)


def _work(log: Log) -> float:
    """Work of the drives, in any unit."""
    angle, torque = log["theta"], log["tau_meas"]
    way: Array = np.diff(angle.values, axis=0)
    there = [np.interp(angle.time[1:], torque.time, column) for column in torque.values.T]
    return float((way * np.stack(there, axis=1)).sum()) if len(there) == way.shape[1] else 0.0

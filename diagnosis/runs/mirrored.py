"""Axes whose angle and torque both count the other way round.

Such an axis is the same by itself; only what couples it to the others changes sign: Coriolis terms,
products of inertia, gravity of bodies that stand out to a side. That may be far less than what
masses of the file that are wrong leave, but has a form of its own. The nominal torque is parted,

    tau = even + share odd + friction and rotors,

into what stays with the axis turned over, even, and what changes sign with it, odd. The share is
1, and -1 where the axis counts the other way round; an arm that is its own mirror image has none.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Base
from flexhex.diagnosis.runs.arrangements import Arrangement, Seen, turned
from flexhex.diagnosis.runs.nominal import NEARLY, SURE, beside_friction, nominal_torque

Array = NDArray[np.float64]
ROUNDS = 4
"""Fits, each of which weights the axes by what the one before leaves of them."""
CLUSTERS = 30
"""Stretches of all instants whose errors are taken for independent."""
LEAST = 1e-6
"""Share of an axis' mean square below which there is nothing: what rounding leaves."""


def mirrored(base: Base, seen: Sequence[Seen]) -> Arrangement | None:
    """The axis of which the nominal torque explains the measured ones only with angle and torque
    negated: its share is -1 within the factor by which that torque may be wrong, for sure. The
    surest one; None where there is none."""
    found, given = list[tuple[float, Arrangement]](), nominal_torque(base, seen)
    for i in range(base.n):
        way = turned(base, i)
        other = nominal_torque(base, [way.of(s) for s in seen]) * way.torque
        share, deviation = _share(seen, (given + other) / 2, (given - other) / 2)
        if share >= -NEARLY and share + SURE * deviation <= -1 / NEARLY:
            found.append((deviation / share, way))
    return max(found, key=lambda one: one[0])[1] if found else None


def _share(seen: Sequence[Seen], even: Array, odd: Array) -> tuple[float, float]:
    """Share of the odd torque (samples, n) in the measured ones beside the even one and friction,
    and its standard deviation; 0 and infinity where there is none."""
    axes = [_axis(seen, even[:, k], odd[:, k], k) for k in range(even.shape[1])]
    if max(float(x @ x) / len(x) for _, x in axes) < LEAST:
        return 0.0, np.inf
    level, share, curvature = np.ones(len(axes)), 0.0, 1.0
    for _ in range(ROUNDS):
        pairs = list(zip(axes, level, strict=True))
        curvature = sum(float(x @ x) / own for (_, x), own in pairs)
        share = sum(float(x @ y) / own for (y, x), own in pairs) / curvature
        level = np.array([max(((y - share * x) ** 2).mean(), LEAST) for y, x in axes])
    slope = sum((y - share * x) * x / own for (y, x), own in zip(axes, level, strict=True))
    parts = [float(part.sum()) ** 2 for part in np.array_split(np.asarray(slope), CLUSTERS)]
    return share, float(np.sqrt(sum(parts)) / curvature)


def _axis(seen: Sequence[Seen], even: Array, odd: Array, axis: int) -> tuple[Array, Array]:
    """Measured and odd torque (samples,) of an axis without what even torque, friction and rotor
    explain of them, in deviations of the former."""
    own, others, tau = beside_friction(seen, even, axis)
    odd = odd / max(float(np.concatenate([s.tau[:, axis] for s in seen]).std()), 1e-300)
    left, sizes, _ = np.linalg.svd(np.column_stack([own, others]), full_matrices=False)
    known = left[:, sizes > LEAST * sizes[0]]
    return tau - known @ (known.T @ tau), odd - known @ (known.T @ odd)

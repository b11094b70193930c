"""Where the fit of a base model begins."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Base
from flexhex.diagnosis.jointfit.rubbed import friction
from flexhex.diagnosis.runs.blocks import Block, torque_at
from flexhex.diagnosis.runs.span import LATEST

Array = NDArray[np.float64]
COARSE, FIRM = 4, 1e-9
"""Rows of which one is taken; ridge of the fit, relative."""


def first_guess(base: Base, blocks: Sequence[Block], late: float) -> tuple[Array, float]:
    """Linear parameters p and delay of the torques [s] to whole samples of the log, from which
    Gauss-Newton steps find the rest: with another delay their columns are turned by a good part of
    a period, and without parameters no torque says how late it is.

    Of all delays within `LATEST` tolerances, late [s], the one at which the linear base model and
    friction leave least, if that is less than half of what they leave without: else something else
    is missing.
    """
    step = max(block.run.tau.ts for block in blocks)
    most = int(LATEST * late / step)
    thin = [
        replace(b, at=b.at[::COARSE], usable=b.usable[::COARSE], moves=b.moves[::COARSE])
        for b in blocks
    ]
    scale = np.array([k.tolerance for k in base.linear])
    nominal = np.array([k.nominal for k in base.linear])
    scale = np.where(np.isfinite(scale), scale, 1.0)
    free = [1.0 if np.isfinite(k.tolerance) else 0.0 for k in base.linear]
    rubbed = friction(blocks)
    more = rubbed[0].shape[2]
    prior = np.diag([*free, *np.zeros(more)])
    few, every = slice(None, None, COARSE), range(len(nominal))
    pairs = zip(blocks, rubbed, strict=True)
    columns = [np.concatenate([b.linear.at(every, few), f[few]], axis=2) for b, f in pairs]
    B = np.concatenate([c[t.usable] for c, t in zip(columns, thin, strict=True)])
    known = [b.linear.times(base.loaded(nominal, b.run.payload), few) for b in blocks]
    size = np.maximum(B.std(axis=(0, 1)), np.finfo(float).tiny)
    weight = np.where(np.diag(prior) > 0, np.append(scale, np.ones(more)), 1.0 / size)
    left, solutions = dict[int, float](), dict[int, Array]()

    def later(k: int) -> Array:
        y = [torque_at(t, base.window, k * step) - a for t, a in zip(thin, known, strict=True)]
        return np.concatenate([v[t.usable] for v, t in zip(y, thin, strict=True)])

    # each axis counts by its own torque
    unit = np.maximum(later(0).std(axis=0), np.finfo(float).tiny)
    C = (B * weight / unit[:, None]).reshape(-1, len(weight))
    own = C.T @ C
    G = own + prior + FIRM * np.diag(np.diag(own) + 1.0)
    for k in range(-most, most + 1):
        v = (later(k) / unit).ravel()
        right = C.T @ v
        solutions[k] = np.linalg.solve(G, right)
        left[k] = float(v @ v - right @ solutions[k])
    best = min(left, key=lambda k: (left[k], abs(k)))
    best = best if left[best] < left[0] / 2 else 0
    count = len(nominal)
    return nominal + (weight * solutions[best])[:count], step * best

"""What a model explains of each axis' torque, and what it leaves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexhex.diagnosis.selection.criteria import Criteria
from flexhex.diagnosis.selection.moments import Moments


@dataclass(frozen=True)
class Rest:
    """What repeats of an axis' torque and is explained by nothing: relative RMS, how many standard
    errors it stands above zero, and what to explain all of it would gain at most [nats]."""

    size: float
    deviations: float
    gain: float = 0.0


def explained(plain: Moments, moments: Moments, criteria: Criteria) -> tuple[float, ...]:
    """Relative RMS of what the terms of a model add to each axis' torque, beside the same
    parameters of the base model, which plain has without terms."""
    alone = plain.loosened(list(moments.freed), criteria.loose**-2.0)
    q, before = moments.fit(None).q, alone.fit(None).q
    more = [moments.torque(i, q) - alone.torque(i, before) for i in range(moments.rows.n)]
    relative = np.sqrt([(v**2).mean() for v in more]) / moments.rows.torque_rms
    return tuple(relative.tolist())


def rest_of(moments: Moments) -> tuple[Rest, ...]:
    """What passes have in common of each axis in the fit to all folds, and nothing explains: it
    repeats, or comes again with the opposite sign, as an oscillation of its own may."""
    rows, q, pairs = moments.rows, moments.fit(None).q, moments.rows.pairs
    chance = float(np.sqrt(2.0 * (pairs.data**2).sum())) or np.inf
    rests = []
    for i in range(rows.n):
        there = rows.moving[i]
        left = rows.level(rows.y[i] - moments.torque(i, q)) * there
        white = rows.level(rows.white_y[i] - moments.white(i, q))
        weight = float(there @ (pairs @ there)) or np.inf
        size = np.sqrt(abs(float(left @ (pairs @ left))) / weight) / rows.torque_rms[i]
        # whitened noise has a variance of one
        squares = abs(float(white @ (pairs @ white)))
        rests.append(Rest(float(size), squares / chance, squares / 2))
    return tuple(rests)

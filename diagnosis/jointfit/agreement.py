"""A delay of the torques is one of the logger, so all axes have it: whether they say so."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Known
from flexhex.diagnosis.regression.calibrate import Calibrated
from flexhex.diagnosis.regression.design import beside_of

Array = NDArray[np.float64]
SURE = 4.0
"""Standard deviations that their median stands above zero."""
NORMAL = 1.4826
"""Standard deviation of normal values over the median of their distances from their median."""


def axes_agree(model: Calibrated) -> bool:
    """Whether the delays of the axes, each by itself, stand together above zero: their median
    against how far they lie apart. A wrong model makes another delay on each axis."""
    delays = own_delays(model)
    if len(delays) < 3:
        return True
    middle = float(np.median(delays))
    apart = NORMAL * float(np.median(np.abs(delays - middle)))
    least = SURE * few(len(delays) - 1) * apart / float(np.sqrt(len(delays)))
    return abs(middle) > least


def own_delays(model: Calibrated) -> Array:
    """Delays (n,) [s] that each axis would have by itself, beside all that the model has."""
    place = next(i for i, known in enumerate(model.known) if known.group == "delay")
    n = model.base.n
    columns = [
        np.stack([design.at(i, np.array([place])) * np.eye(n)[i] for i in range(n)], axis=1)
        for design in model.B
    ]
    own = [Known(f"delay[{i + 1}]", "s", 0.0, np.inf, "delay", i) for i in range(n)]
    known = (*model.known[:place], *model.known[place + 1 :], *own)
    kept = np.delete(np.arange(len(model.known)), place)
    scale = np.append(model.scale[kept], np.full(n, model.scale[place]))
    B = tuple(beside_of(d.only(kept), c) for d, c in zip(model.B, columns, strict=True))
    regression = replace(model, known=known, scale=scale, B=B).regression
    return np.asarray(regression.q[-n:] * scale[-n:])


def few(count: int) -> float:
    """Factor of a standard deviation that so many squares tell, with which a normal density falls
    as far at `SURE` deviations as Student's does.

    (count + 1) / 2 log(1 + t^2 / count) = SURE^2 / 2, solved for t / SURE.
    """
    t = math.sqrt(count * math.expm1(SURE**2 / (count + 1)))
    return t / SURE

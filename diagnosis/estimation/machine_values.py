"""Which parameters of a fit are a machine's: bodies, and what is never negative."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Known
from flexhex.diagnosis.estimation.bodies import Possible, bodies_of, consistent, possible
from flexhex.diagnosis.regression.calibrate import Calibrated

Array = NDArray[np.float64]


def possible_values(
    model: Calibrated, values: Array, curvature: Array
) -> tuple[Possible, dict[str, tuple[int, ...]]]:
    """Values that a machine can have, and the places, by name, of what none has before."""
    known, more = model.known, announced(model)
    # a parameter that the file has exactly has no scale, and no curvature
    times = np.divide(1.0, model.scale, out=np.zeros_like(model.scale), where=model.scale > 0)
    curved = curvature * np.outer(times, times)
    file = np.array([one.nominal for one in known]) + more
    bodies = [(body, file[list(body.places)]) for body in bodies_of(known)]
    inside = {place for body, _ in bodies for place in body.places}
    positive = [k for k, one in enumerate(known) if k not in inside and never_negative(one)]
    result = possible(values + more, curved, bodies, positive)
    whole = values + more
    wrong = {b.name: b.places for b, _ in bodies if not consistent(whole[list(b.places)])}
    wrong |= {known[k].name: (k,) for k in positive if whole[k] < 0}
    return replace(result, values=result.values - more), wrong


def announced(model: Calibrated) -> Array:
    """What the logs' heads say of payloads (nb,): their parameters are differences from it."""
    values, base = np.zeros(len(model.known)), model.base
    p = np.array([known.nominal for known in base.linear])
    places = list(base.payload)
    for load in model.loads:
        if load.mass:
            values[model.places(load)] = (base.loaded(p, float(load.mass)) - p)[places]
    return values


def never_negative(known: Known) -> bool:
    """Whether no machine has this parameter below zero: what is positive by its kind, and rotors,
    inertias of axes, friction."""
    kind = known.name.rpartition(".")[2].partition("[")[0]
    return (known.positive or known.bounded) or (
        known.axis is not None and kind in ("J", "m", "J_r", "m_r", "F_c", "d")
    )

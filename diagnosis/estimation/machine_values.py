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
    made: Calibrated, values: Array, curvature: Array
) -> tuple[Possible, dict[str, tuple[int, ...]]]:
    """Values that a machine can have, and the places, by name, of what none has before."""
    known, more = made.known, announced(made)
    # a parameter that the file has exactly has no scale, and no curvature
    times = np.divide(1.0, made.scale, out=np.zeros_like(made.scale), where=made.scale > 0)
    curved = curvature * np.outer(times, times)
    file = np.array([one.nominal for one in known]) + more
    bodies = [(body, file[list(body.places)]) for body in bodies_of(known)]
    inside = {place for body, _ in bodies for place in body.places}
    positive = [k for k, one in enumerate(known) if k not in inside and never_negative(one)]
    found = possible(values + more, curved, bodies, positive)
    whole = values + more
    wrong = {b.name: b.places for b, _ in bodies if not consistent(whole[list(b.places)])}
    wrong |= {known[k].name: (k,) for k in positive if whole[k] < 0}
    return replace(found, values=found.values - more), wrong


def announced(made: Calibrated) -> Array:
    """What the logs' heads say of payloads (nb,): their parameters are differences from it."""
    found, base = np.zeros(len(made.known)), made.base
    p = np.array([known.nominal for known in base.linear])
    places = list(base.payload)
    for load in made.loads:
        if load.mass:
            found[made.places(load)] = (base.loaded(p, float(load.mass)) - p)[places]
    return found


def never_negative(known: Known) -> bool:
    """Whether no machine has this parameter below zero: what is positive by its kind, and rotors,
    inertias of axes, friction."""
    kind = known.name.rpartition(".")[2].partition("[")[0]
    return (known.positive or known.bounded) or (
        known.axis is not None and kind in ("J", "m", "J_r", "m_r", "F_c", "d")
    )

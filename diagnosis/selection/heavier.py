"""A body whose mass is not the one of the machine file, as a part of the base model."""

from __future__ import annotations

from copy import copy
from dataclasses import replace

import numpy as np

from flexhex.diagnosis.hypotheses.candidates import Bench
from flexhex.diagnosis.selection.hypothesis import HeavierBody
from flexhex.diagnosis.selection.moments import Moments


def heavier(bench: Bench, body: HeavierBody, moments: Moments) -> Bench:
    """The same beside a base model in which a body has the mass that a fit gives it."""
    model, places, ways = bench.model, list(body.places), body.direction
    (G, b), fit = moments.gram(None), moments.fit(None)
    columns = G[:, places] @ ways
    curvature = ways @ columns[places] - columns @ fit.solve(columns)
    more = float((ways @ b[places] - columns @ fit.q) / (curvature + 1.0))
    known = list(model.known)
    for place in places:
        old = known[place]
        known[place] = replace(old, nominal=(1 + more) * old.nominal, file=old.written)
    base = copy(model.base)
    base.linear = tuple(known[: len(base.linear)])
    step = np.zeros(len(known))
    step[places] = more * ways
    y = tuple(model.residual(step))
    return bench.beside(replace(model, base=base, known=tuple(known), y=y))

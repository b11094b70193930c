"""A body whose mass is not the one of the machine file, as a part of the base model."""

from __future__ import annotations

from copy import copy
from dataclasses import replace

import numpy as np

from flexhex.diagnosis.hypotheses.candidates import Bench
from flexhex.diagnosis.selection.changed import HeavierBody
from flexhex.diagnosis.selection.moments import Moments


def moved_gain(moments: Moments) -> float:
    """What a model loses if the bodies that have another mass get the machine file's again, within
    the tolerances that they had, and all other parameters follow [nats]."""
    model = moments.rows.model
    moved = np.array([known.nominal - known.written for known in model.known])
    step = np.zeros(moments.m)
    step[: len(moved)] = np.divide(moved, model.scale, where=moved != 0, out=np.zeros(len(moved)))
    written = moments.loosened([k for k, known in enumerate(model.known) if known.wider > 1], 1.0)
    G, b = moments.gram(None)
    back = b + G @ step
    there = written.fit(None).solve(back)
    worse = step @ (b + back) - back @ there + b @ moments.fit(None).q
    return float(worse) / 2


def heavier(bench: Bench, body: HeavierBody, moments: Moments) -> Bench:
    """The same beside a base model in which a body has the mass that a fit gives it.

    Its other parameters went along, as of a body of the same shape: of what came or went nobody
    knows where it is, so that all of them may be off by as many tolerances as the mass is.
    """
    model, places, ways = bench.model, list(body.places), body.direction
    (G, b), fit = moments.gram(None), moments.fit(None)
    columns = G[:, places] @ ways
    curvature = ways @ columns[places] - columns @ fit.solve(columns)
    held = moments.rows.often(places)
    more = float((ways @ b[places] - columns @ fit.q) / (curvature + held))
    known = list(model.known)
    off = [abs(more * way) for way, k in zip(ways, places, strict=True) if known[k].positive]
    wider = max([1.0, *off])
    for place in places:
        old = known[place]
        known[place] = replace(old, nominal=(1 + more) * old.nominal, file=old.written, wider=wider)
    base = copy(model.base)
    base.linear = tuple(known[: len(base.linear)])
    step = np.zeros(len(known))
    step[places] = more * ways
    y = tuple(model.residual(step))
    return bench.beside(replace(model, base=base, known=tuple(known), y=y))

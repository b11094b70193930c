"""Parameters and their sums with intervals, and whether the runs determine them."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.estimation.estimate import Estimated
from flexhex.diagnosis.estimation.extras import GROUP as EFFECT
from flexhex.diagnosis.estimation.friction import GROUP as FRICTION
from flexhex.diagnosis.estimation.machine_values import announced, never_negative
from flexhex.diagnosis.estimation.structure import Combination
from flexhex.diagnosis.regression.gram import safe_inverse
from flexhex.diagnosis.result.estimates import Estimate, Parameter
from flexhex.diagnosis.result.verdict import NORMAL
from flexhex.diagnosis.runs.nominal import SURE

Array = NDArray[np.float64]
NARROWER, WIDER = 0.5, 10.0
"""A parameter is determined by the runs if its standard deviation is this much smaller than what
was known of it, and would be with tolerances so much wider: else the file's other values do it;"""
SMALL = 0.05
"""or, where nothing was known, if its standard deviation makes less than this share of an axis'
torque, or it is `SURE` of them away from zero."""
UNSEEN = 1e-4
"""Share of a combination that lies where neither runs nor file say anything: it has no value."""


class Seen:
    """What the runs say of parameters and their sums; out: names of what `pruned` left out."""

    def __init__(self, estimated: Estimated, out: Sequence[str] = ()) -> None:
        self.estimated, model, reg = estimated, estimated.model, estimated.regression
        self.more = announced(model)
        self.exact = {
            place
            for place, known in enumerate(estimated.known)
            if known.tolerance == 0 and known.name not in out
        }
        G = np.diag(reg.prior) + reg.gram[0]
        self.unseen = np.eye(len(G)) - reg.covariance @ G
        loose = reg.prior / WIDER**2
        self.alone = estimated.level * safe_inverse(G - np.diag(reg.prior - loose), loose)
        count = sum(len(y) for y in model.y)
        squares = [[np.diag(B.squares(i)) for B in model.B] for i in range(model.base.n)]
        rms = np.sqrt(np.sum(squares, axis=1) / count)
        torque = np.maximum(model.torque_rms, np.finfo(float).tiny)
        scale = np.where(model.scale > 0, model.scale, np.inf)
        self.share = (rms / torque[:, None]).max(axis=0) / scale

    def parameter(
        self, combination: Combination, vague: bool = False, by_size: bool = False
    ) -> Parameter:
        """A sum of parameters by their places; vague: others make its torque as well; by_size:
        that it is away from zero determines nothing."""
        estimated, known = self.estimated, self.estimated.known
        places = [place for place, _ in combination.terms]
        c = np.zeros(len(known))
        c[places] = [factor for _, factor in combination.terms]
        value = float(c @ (estimated.values + self.more))
        # what is assumed of friction and effects is no file's tolerance
        ours = [known[p].group in (FRICTION, EFFECT) for p in places]
        told = [p for own, p in zip(ours, places, strict=True) if not own]
        file = float(sum(c[p] * (known[p].nominal + self.more[p]) for p in told))
        file += sum(c[p] * estimated.extras.written.get(known[p].name, 0.0) for p in places)
        wide = [np.inf if own else known[p].tolerance for own, p in zip(ours, places, strict=True)]
        tolerance = float(np.linalg.norm(np.abs(c[places]) * np.array(wide)))
        q = c * estimated.model.scale
        lost = np.linalg.norm(self.unseen.T @ q) > UNSEEN * np.linalg.norm(q)
        deviation = (
            math.inf if lost or vague else math.sqrt(max(float(c @ estimated.covariance @ c), 0.0))
        )
        alone = math.sqrt(max(float(q @ self.alone @ q), 0.0))
        if math.isfinite(tolerance):
            determined = max(deviation, alone) < NARROWER * tolerance
        else:
            fitted = [p for p in places if estimated.model.scale[p] > 0] or places
            size = float((self.share[fitted] / np.abs(c[fitted])).min())
            unsure = max(deviation, alone)
            away = not by_size and abs(value) > SURE * unsure
            determined = size > 0 and (unsure * size < SMALL or away)
        against = abs(float(c @ (estimated.free - estimated.values)))
        determined &= against <= SURE * deviation
        low, high = value - NORMAL * deviation, value + NORMAL * deviation
        if len(places) == 1 and (never_negative(known[places[0]]) or known[places[0]].positive):
            low = max(low, 0.0)
        terms = tuple((known[p].name, float(c[p])) for p in places)
        estimate = Estimate(value, (low, high), known[places[0]].printed)
        exact = self.exact.issuperset(places)
        return Parameter(terms, estimate, file, tolerance, bool(determined), exact)

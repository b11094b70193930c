"""Friction and inertias of axes that the runs alone would have below zero: findings."""

from __future__ import annotations

import numpy as np

from flexhex.diagnosis.estimation.estimate import Estimated
from flexhex.diagnosis.kinds import kinds_of
from flexhex.diagnosis.result.negative import HAVE, Asked, below_zero, rates_of
from flexhex.diagnosis.runs.nominal import SURE


def negative_values(estimated: Estimated) -> tuple[list[str], set[str]]:
    """A sentence for each axis, and the parameters that they speak of."""
    findings, names, base = list[str](), set[str](), estimated.model.base
    deviation = np.sqrt(np.maximum(np.diag(estimated.covariance), 0.0))
    for i, kind in enumerate(kinds_of(base, base.n)):
        wanted = [f"{name}[{i + 1}]" for name in HAVE]
        own = [
            Asked(known.name, float(estimated.free[k]), float(deviation[k]), known.printed)
            for k, known in enumerate(estimated.known)
            if known.name in wanted
        ]
        text = below_zero(i, kind, own, rates_of(estimated.model.blocks, i), SURE)
        if text:
            findings.append(f"{text}. The parameters are the nearest that a machine can have")
            names.update(one.name for one in own if one.value < -SURE * one.deviation)
    return findings, names

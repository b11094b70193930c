"""Base parameters that left their tolerances: their values with intervals."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flexhex.diagnosis.answer import Joint
from flexhex.diagnosis.verdict import Changed, Estimate

CORRELATED = 3.0
"""Rows that count as one, for what the noise model does not know."""


def changed_of(held: Joint, bodies: Sequence[Sequence[int]]) -> list[Changed]:
    """Parameters (places in `known`) that changed, of each body or alone.

    Of a body those are given whose interval does not hold the value of the machine file; one at
    least.
    """
    made = held.bench.made
    regression = made.regression.loosened(held.freed)
    if held.parts:
        regression = regression.extended([part.columns for part in held.parts])
    level = max(1.0, float((regression.residual**2).mean())) * CORRELATED
    found: dict[int, tuple[float, Changed]] = {}
    for places in bodies:
        own = {
            place: _estimate(held, place, regression.variance(place) * level) for place in places
        }
        clear = {place for place, (off, _) in own.items() if off > 1.0}
        most = max(own, key=lambda place: own[place][0])
        found |= {place: own[place] for place in sorted(clear | {most})}
    return [change for _, change in found.values()]


def _estimate(held: Joint, place: int, variance: float) -> tuple[float, Changed]:
    """How far off in half intervals, and the value."""
    made = held.bench.made
    known, scale = made.known[place], float(made.scale[place])
    move, reach = scale * float(held.q[place]), 1.96 * scale * float(np.sqrt(variance))
    value = known.nominal + move
    estimate = Estimate(value, (value - reach, value + reach), known.unit)
    return abs(move) / max(reach, np.finfo(float).tiny), Changed(
        known.name, known.nominal, estimate
    )

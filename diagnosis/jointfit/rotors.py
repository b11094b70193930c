"""What effects behind gears owe to rotor inertias, which runs and file tell only so well."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.hypotheses.candidates import Bench
from flexhex.diagnosis.jointfit.effects import Part
from flexhex.diagnosis.regression.regression import Columns, Regression

Array = NDArray[np.float64]


def rotor_changes(
    bench: Bench, regression: Regression, parts: Sequence[Part], columns: Array
) -> Array:
    """Change of the torque of parts with these columns (R, k) by one standard deviation of each
    rotor inertia that they depend on (R, r).

    A rotor and the body that it turns move alike: where nothing else turns that body, only what is
    known of it tells them apart. The other parameters move as their estimates go with the rotor's.
    """
    effects = bench.effects
    own = {k: p.axis for k, p in enumerate(parts) if p.axis is not None and p.id in effects}
    geared = {k: axis for k, axis in own.items() if effects[parts[k].id].effect.geared}
    if not geared:
        return np.zeros((len(columns), 0))
    model, (_, beta) = bench.model, regression.fall(Columns(None, columns))
    edges = np.cumsum([0, *(part.columns.values.shape[1] for part in parts)])

    def torque(move: Array) -> Array:
        fitted = replace(model.fitted, p=model.fitted.p + move)
        moved = bench.beside(replace(model, fitted=fitted))
        there = (parts[k].moved(moved, parts[k].shape) for k in geared)
        gains = (beta[edges[k] : edges[k + 1]] for k in geared)
        pairs = zip(there, gains, strict=True)
        return np.asarray(sum(regression.spread(part.columns) @ gain for part, gain in pairs))

    changes, count = list[Array](), len(model.fitted.p)
    for axis in dict.fromkeys(geared.values()):
        place = model.base.rotors[axis]
        wider = np.sqrt(regression.doubt[:count] * regression.doubt[place])
        column = wider * regression.covariance[:count, place]
        move = model.scale[:count] * column / np.sqrt(max(column[place], np.finfo(float).tiny))
        changes.append((torque(move) - torque(-move)) / 2)
    return np.column_stack(changes)

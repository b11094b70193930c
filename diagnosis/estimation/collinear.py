"""Free parameters whose columns go together on these motions: spring, gravity and offset of an axis
that turns a little cancel in hundreds.

Of such columns those are left out that nothing is lost without (Schwarz' criterion), one after
another. What is left of them has a value together alone: the mean torque that they make.
"""

from __future__ import annotations

import math
from copy import copy
from dataclasses import replace

import numpy as np

from flexhex.diagnosis.estimation.determined import Seen
from flexhex.diagnosis.estimation.estimate import Estimated, again
from flexhex.diagnosis.estimation.structure import Combination

COLLINEAR = 0.01
"""Share of a column's square that is left beside the others. Of springs and gravity terms of axes
that turn by less than a radian 3e-10 to 5e-3 were, of all other terms 0.01 and more."""


def pruned(estimated: Estimated) -> tuple[Estimated, list[str]]:
    """The fit without columns that nothing is lost without, and a sentence for each axis."""
    out = list[str]()
    while names := _needless(estimated):
        base = copy(estimated.model.base)
        base.linear = tuple(
            replace(known, tolerance=0.0) if known.name in names else known for known in base.linear
        )
        estimated = again(estimated, base)
        out += names
    if not out:
        return estimated, []
    order = [known.name for known in estimated.known]
    listed = ", ".join(sorted(out, key=order.index))
    return estimated, [
        f"{listed}: these motions do not distinguish them from other terms, and nothing is lost"
        " without: left out, at the value of the model's file or zero"
    ]


def grouped(estimated: Estimated) -> tuple[list[Combination], list[str]]:
    """Sums with a value where their terms have none, and a sentence for each."""
    seen, sums, notes = Seen(estimated), list[Combination](), list[str]()
    for places in _collinear(estimated, seen).values():
        if len(places) < 2:
            continue
        axis = estimated.known[places[0]].axis or 0
        columns = [B.at(axis, np.array(places)) for B in estimated.model.B]
        means = np.concatenate(columns).mean(axis=0) / estimated.model.scale[places]
        if not means[0]:
            continue
        factors = (means / means[0]).tolist()
        sums.append(Combination(tuple(zip(places, factors, strict=True))))
        names = ", ".join(estimated.known[place].name for place in places)
        notes.append(
            f"{names} cancel each other on these motions: a value of one alone means nothing, their"
            " sum is the mean torque that they make. Wider motions tell them apart"
        )
    return sums, notes


def _needless(estimated: Estimated) -> list[str]:
    """Of each axis the one that costs least, if that is less than a parameter is worth."""
    regression, names = estimated.regression, list[str]()
    most = estimated.level * math.log(len(regression.y))
    for places in _collinear(estimated, Seen(estimated)).values():
        own = np.diag(regression.covariance)[places]
        cost = regression.q[places] ** 2 / np.maximum(own, np.finfo(float).tiny)
        if len(places) > 1 and cost.min() < most:
            names.append(estimated.known[places[int(np.argmin(cost))]].name)
    return names


def _collinear(estimated: Estimated, seen: Seen) -> dict[int, list[int]]:
    """Places of free parameters that the runs do not determine, as others make their torque, by
    axis."""
    regression, places = estimated.regression, dict[int, list[int]]()
    inflated = np.diag(regression.covariance) * np.diag(regression.gram[0])
    for place, known in enumerate(estimated.model.base.linear):
        free = math.isinf(known.tolerance) and known.axis is not None
        if free and inflated[place] * COLLINEAR > 1 and not _determined(seen, place):
            places.setdefault(known.axis or 0, []).append(place)
    return places


def _determined(seen: Seen, place: int) -> bool:
    return seen.parameter(Combination(((place, 1.0),))).determined

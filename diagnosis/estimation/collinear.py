"""Free parameters whose columns go together on these motions: spring, gravity and offset of an axis
that turns a little make the same torque, and cancel in hundreds.

Of such columns those are left out that nothing is lost without (Schwarz' criterion), one after
another. As with base parameters the others then stand for them, too: where x_d = sum_j beta_j x_j
on the rows, only the sums p_j + beta_j p_d have values. Columns that are needed but go together
have one as the mean torque that they make.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import replace

import numpy as np

from flexhex.diagnosis.estimation.determined import Seen
from flexhex.diagnosis.estimation.estimate import Estimated, again
from flexhex.diagnosis.estimation.structure import Combination

COLLINEAR = 0.01
"""Share of a column's square that is left beside the others. Of springs and gravity terms of axes
that turn by less than a radian 3e-10 to 5e-3 were, of all other terms 0.01 and more."""
SLIGHT = math.sqrt(COLLINEAR)
"""Share of a column that is left out (RMS) below which another one has no part in it: as much of it
may be left."""


def pruned(estimated: Estimated) -> tuple[Estimated, list[str]]:
    """The fit without columns that nothing is lost without, and their names."""
    out = list[str]()
    while names := _needless(estimated):
        base = copy(estimated.model.base)
        base.linear = tuple(
            replace(known, tolerance=0.0) if known.name in names else known for known in base.linear
        )
        estimated = again(estimated, base)
        out += names
    order = [known.name for known in estimated.known]
    return estimated, sorted(out, key=order.index)


def grouped(estimated: Estimated, out: Sequence[str]) -> tuple[list[Combination], list[str]]:
    """Sums that have a value where their terms have none, and a sentence for each kind; out: names
    of what is left out."""
    stand = _standing_for(estimated, out)
    needed = [places for places in _collinear(estimated).values() if len(places) > 1]
    together = [_together(estimated, places, stand) for places in needed]
    together = [one for one in together if len(one.terms) > 1]
    inside, notes = {place for one in together for place, _ in one.terms}, list[str]()
    alone = [
        Combination(((place, 1.0), *more)) for place, more in stand.items() if place not in inside
    ]
    gone = [name for name in out if any(name in _names(estimated, one)[1:] for one in alone)]
    if gone:
        notes.append(
            f"{', '.join(gone)}: on these motions other terms make the same torque, so that sums"
            " alone have values. Wider motions tell them apart"
        )
    for one in together:
        names = ", ".join(_names(estimated, one))
        notes.append(
            f"{names} cancel each other on these motions: a value of one alone means nothing, their"
            " sum is the mean torque that they make. Wider motions tell them apart"
        )
    return [*alone, *together], notes


def _names(estimated: Estimated, one: Combination) -> list[str]:
    return [estimated.known[place].name for place, _ in one.terms]


def _standing_for(
    estimated: Estimated, out: Sequence[str]
) -> dict[int, tuple[tuple[int, float], ...]]:
    """Free parameters with the terms that are left out on their axis and that they stand for."""
    linear, more = estimated.model.base.linear, dict[int, tuple[tuple[int, float], ...]]()
    for gone in (place for place, known in enumerate(linear) if known.name in out):
        axis = linear[gone].axis or 0
        every, blocks = range(len(linear)), estimated.model.blocks
        rows = np.concatenate([b.linear.at(every)[b.usable, axis] for b in blocks])
        kept = [
            place
            for place, known in enumerate(linear)
            if math.isinf(known.tolerance) and known.axis == axis and rows[:, place].any()
        ]
        size = np.sqrt((rows**2).mean(axis=0))
        beta = np.linalg.lstsq(rows[:, kept] / size[kept], rows[:, gone] / size[gone])[0]
        for place, part in zip(kept, beta, strict=True):
            if abs(part) > SLIGHT:
                factor = float(part * size[gone] / size[place])
                more[place] = (*more.get(place, ()), (gone, factor))
    return dict(sorted(more.items()))


def _together(
    estimated: Estimated,
    places: Sequence[int],
    stand: Mapping[int, tuple[tuple[int, float], ...]],
) -> Combination:
    """Collinear parameters of an axis as the mean torque that they make, with what they stand
    for; one alone where there is none."""
    axis = estimated.known[places[0]].axis or 0
    columns = np.concatenate([B.at(axis, np.array(places)) for B in estimated.model.B])
    means = columns.mean(axis=0) / estimated.model.scale[list(places)]
    if not means[0]:
        return Combination(((places[0], 1.0),))
    factors = dict(zip(places, (means / means[0]).tolist(), strict=True))
    for place in places:
        for gone, factor in stand.get(place, ()):
            factors[gone] = factors.get(gone, 0.0) + factors[place] * factor
    return Combination(tuple(factors.items()))


def _needless(estimated: Estimated) -> list[str]:
    """Of each axis the one that costs least, if that is less than a parameter is worth."""
    regression, names = estimated.regression, list[str]()
    most = estimated.level * math.log(len(regression.y))
    for places in _collinear(estimated).values():
        own = np.diag(regression.covariance)[places]
        cost = regression.q[places] ** 2 / np.maximum(own, np.finfo(float).tiny)
        if len(places) > 1 and cost.min() < most:
            names.append(estimated.known[places[int(np.argmin(cost))]].name)
    return names


def _collinear(estimated: Estimated) -> dict[int, list[int]]:
    """Places of free parameters that the runs do not determine, as others make their torque, by
    axis."""
    regression, seen, places = estimated.regression, Seen(estimated), dict[int, list[int]]()
    inflated = np.diag(regression.covariance) * np.diag(regression.gram[0])
    for place, known in enumerate(estimated.model.base.linear):
        free = math.isinf(known.tolerance) and known.axis is not None
        same = free and inflated[place] * COLLINEAR > 1
        # two that cancel each other are both well away from zero
        if same and not seen.parameter(Combination(((place, 1.0),)), by_size=True).determined:
            places.setdefault(known.axis or 0, []).append(place)
    return places

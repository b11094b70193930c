"""Something without a name that an axis may have: any function of what it is made of."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from flexhex.diagnosis.selection.changed import Axis
from flexhex.diagnosis.selection.hypothesis import Array, ColumnsByAxis, EffectHypothesis


@dataclass(frozen=True)
class NamelessHypothesis:
    """Columns of something without a name, raw (R, k) [N m] on each axis that feels them, and how
    their coefficients go together, each (k, k'); place: where they stand among those of `within`,
    of which products are known."""

    columns: EffectHypothesis
    raw: Mapping[int, Array]
    ways: tuple[Array, ...]
    within: EffectHypothesis
    place: slice


def nameless(
    axis: Axis,
    argument: str,
    columns: ColumnsByAxis,
    ways: tuple[Array, ...],
    within: EffectHypothesis | None = None,
    place: slice = slice(None),
) -> NamelessHypothesis:
    """Something without a name from its columns (R, k) on an axis or on several."""
    felt, count = tuple(columns.raw), next(iter(columns.raw.values())).shape[1]
    most = np.full(count, np.inf)
    white = columns.white
    hypothesis = EffectHypothesis(
        argument, axis, ({},), lambda _: white, felt, -most, most, count, "", False, 1
    )
    return NamelessHypothesis(hypothesis, columns.raw, ways, within or hypothesis, place)

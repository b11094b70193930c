"""A payload that all runs carry, as the answer to what was doubted of the base model."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import replace

from flexhex.diagnosis.basemodels.base import Base
from flexhex.diagnosis.result.verdict import Changed
from flexhex.diagnosis.runs.pairing import doubtful
from flexhex.diagnosis.runs.run import Run


def answered(base: Base, changed: Sequence[Changed], runs: Sequence[Run]) -> bool:
    """Whether nothing is doubtful with the values that were found, and these are a payload's: of
    the last body alone, which is surely heavier, and not by one factor in all its values, as where
    all torques have another size."""
    found = {one.parameter: one for one in changed if not one.runs}
    heavier = any(
        one.estimate.unit == "kg" and one.estimate.ci95[0] > one.nominal for one in found.values()
    )
    if not heavier or not found.keys() <= {base.linear[place].name for place in base.payload}:
        return False
    ratios = [
        sorted(end / one.nominal for end in one.estimate.ci95)
        for one in found.values()
        if one.nominal
    ]
    if ratios and max(low for low, _ in ratios) <= min(high for _, high in ratios):
        return False
    laden = copy(base)
    laden.linear = tuple(
        replace(known, nominal=found[known.name].estimate.value) if known.name in found else known
        for known in base.linear
    )
    return not doubtful(laden, runs)

"""Which verdict what was found, and what is left, come to."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.regression.calibrate import Calibrated
from flexhex.diagnosis.result.verdict import Changed, Named
from flexhex.diagnosis.selection.criteria import USUAL as CRITERIA
from flexhex.diagnosis.selection.side import Side

Array = NDArray[np.float64]


def verdict_of(
    model: Calibrated,
    sides: Sequence[Side],
    named: Sequence[Named],
    changed: Sequence[Changed],
    notes: list[str],
    coarse: Array,
) -> str:
    """One of `VERDICTS`; what else is to be said of it comes to the notes."""
    if named:
        return "ambiguous" if any(effect.rivals for effect in named) else "named"
    if not model.noise.repeats:
        notes.append("no trajectory was run twice, so noise cannot be set apart: run each again")
        return "changed" if changed else "cannot tell"
    if any(side.remains for side in sides):
        # a rest that is many times what the angles' own error makes is none of it
        least = coarse / CRITERIA.largest_rest
        if all(_left(side).get(a, 0.0) < least[a] for side in sides for a in side.remains):
            notes.append(
                "it may be the error of the encoder, which repeats: finer angles would tell"
            )
            return "changed" if changed else "cannot tell"
        return "unknown"
    if not changed and any(side.refuted for side in sides):
        notes.append(
            "with the parameters that these runs ask for the held-out runs become worse: give some"
            " of those as runs of the fit, too"
        )
        return "cannot tell"
    unconfirmed = any(side.unconfirmed for side in sides)
    return "changed" if changed else "cannot tell" if unconfirmed else "none"


def _left(side: Side) -> dict[int, float]:
    """RMS [N m] of what is left on axes (from 0)."""
    return {rest.axis - 1: rest.rms for rest in side.rests}

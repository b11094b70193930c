"""The base model fitted to runs that are smoothed as long as it takes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Base
from flexhex.diagnosis.jointfit.calmest import calmest
from flexhex.diagnosis.jointfit.fit import calibrate
from flexhex.diagnosis.regression.calibrate import Calibrated
from flexhex.diagnosis.regression.unshown import quiet
from flexhex.diagnosis.regression.window import (
    TWICE,
    Smoother,
    outgrown,
    smoothed,
    smoother,
    unknown_inertias,
    windows,
)
from flexhex.diagnosis.runs.blocks import blocks
from flexhex.diagnosis.runs.run import Run
from flexhex.diagnosis.runs.span import spacing_for

Array = NDArray[np.float64]


def fitted(base: Base, runs: Sequence[Run]) -> tuple[Calibrated, Array, str]:
    """The base model fitted, smoothed as long as noise of angles and motion asks for; the torque
    RMS (n,) [N m] that the angles' still makes; what was done about it, or nothing."""
    # logs in other units than they say end in numbers beyond all bounds, and are told of later
    with np.errstate(over="ignore", invalid="ignore"):
        usual, done = base.window, ""
        while True:
            model = calibrate(base, blocks(base, runs, spacing_for(base, runs)))
            longer = smoother(model, runs, usual)
            if longer.window == base.window:
                more = _longer(model, runs, usual)
                if more is None:
                    return _calmed(model, runs, usual), longer.left, done
                longer = more
            base, done = smoothed(base, longer.window), longer.text


def _calmed(model: Calibrated, runs: Sequence[Run], usual: float) -> Calibrated:
    """The base model of a motion that is not quiet, smoothed as long as it may be."""
    window = calmest(model, usual)
    if window == model.base.window:
        return model
    base = smoothed(model.base, window)
    return calibrate(base, blocks(base, runs, spacing_for(base, runs)))


def _longer(model: Calibrated, runs: Sequence[Run], usual: float) -> Smoother | None:
    """A window under which accelerations are those that the torque shows, and inertias that nobody
    knows are not smaller than they are. Between passes noise makes none smaller, and what grows
    there is a mechanism that swings."""
    if longer := quiet(model, runs, usual):
        return longer
    if model.noise.repeats or not unknown_inertias(model.base):
        return None
    for window in windows(model, usual, TWICE):
        base = smoothed(model.base, window)
        again = calibrate(base, blocks(base, runs, spacing_for(base, runs)))
        if longer := outgrown(model, again, usual):
            return longer
    return None

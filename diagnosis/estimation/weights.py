"""How much the rows of each axis count, and what is known of the parameters beside them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.estimation.identify import correlation_time
from flexhex.diagnosis.jointfit.leftover import axis_rms
from flexhex.diagnosis.jointfit.rubbed import with_friction
from flexhex.diagnosis.regression.calibrate import Calibrated
from flexhex.diagnosis.regression.level import off
from flexhex.diagnosis.regression.regression import Regression
from flexhex.diagnosis.runs.noise import ORDER, Noise

Array = NDArray[np.float64]
WEAK, LEVELS = 1e-4, 3
"""Share of what is known of the parameters that counts at first; fits until it is as it should."""


def even(model: Calibrated, q: Array) -> Noise:
    """Each axis weighted by the RMS that is left of it, all frequencies alike: what a model lacks
    is more than noise, and has another spectrum."""
    left = np.maximum(axis_rms(model.blocks, model.residual(q)), np.finfo(float).tiny)
    n = model.base.n
    return Noise(
        np.zeros((n, ORDER)), *(left,) * 3, model.noise.repeats, np.ones((n, 2)), np.ones(n)
    )


def first_weights(model: Calibrated) -> Noise:
    """`even` of what the runs leave if next to nothing is known of the parameters: begun with the
    file's values, an axis that these fit badly would have no say, and stay so."""
    rubbed = with_friction(model)
    return even(rubbed, _weakly(rubbed.regression).q)


def levelled(model: Calibrated) -> tuple[Regression, float]:
    """The regression with priors that count beside what is left of the rows, of which as many as
    repeat each other count as one; and as well as these runs say that the parameters are known."""
    known = model.regression.prior
    regression, level = _weakly(model.regression), 1.0
    for _ in range(LEVELS):
        left = regression.residual.reshape(model.base.n, -1).T
        level = max(1.0, float((left**2).mean()) * correlation_time(left))
        times = level / off(regression, known[: len(model.base.linear)])
        scaled = {k: float(times * v) for k, v in enumerate(known) if v > 0}
        regression = model.regression.loosened(scaled)
    return regression, level


def _weakly(regression: Regression) -> Regression:
    """The same with next to nothing known of the parameters."""
    known = {k: WEAK * float(v) for k, v in enumerate(regression.prior) if v > 0}
    return regression.loosened(known)

"""A drive that lags, in the place of a log whose torques are late."""

from __future__ import annotations

from flexhex.diagnosis.hypotheses.candidates import Bench
from flexhex.diagnosis.jointfit.answer import Joint, again
from flexhex.diagnosis.jointfit.effects import Part, SelectedEffect
from flexhex.diagnosis.jointfit.fit import held
from flexhex.diagnosis.jointfit.guard import clear, delay_of, left_rms
from flexhex.diagnosis.regression.calibrate import Calibrated

LAG = "drive_lag"
STEPS = 4
"""Fits until the time constant stays: each changes it by about a quarter of the one before."""


def with_lag(fit: Joint, deviations: float) -> Calibrated | None:
    """The base model of a single axis without a delay of the torques, about the time constant of
    the drive's lag that leaves less than that in its place; None if there is none.

    To first order a lag and a delay are the same, and no other axis shows that the log is not late.
    deviations: standard errors that a clear delay stands above zero.
    """
    model, effects = fit.bench.model, list(fit.bench.effects.values())
    lag = -delay_of(fit)[0]
    if model.base.n > 1 or LAG not in fit.bench.effects or lag <= 0 or not clear(fit, deviations):
        return None
    others = tuple(effect for effect in fit.effects if effect.id != LAG)
    most = fit.bench.effects[LAG].effect.gains[0].high
    for _ in range(STEPS):
        bench = Bench(held(model, 0.0, lag), effects)
        late = SelectedEffect(LAG, (Part.of(bench, LAG, 0, {}),))
        lagging = again(Joint(bench, (*others, late), (), fit.q, fit.freed), bench)
        left, lag = left_rms(lagging), float(lagging.beta[-1][0])
        if not 0 < lag <= most or (left >= left_rms(fit)).any():
            return None
    return held(model, 0.0, lag)

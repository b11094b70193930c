"""Whether the runs can be those of the base model's machine."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.jointfit.answer import Joint, axis_rms
from flexhex.diagnosis.regression.calibrate import Calibrated
from flexhex.diagnosis.regression.payloads import GROUP
from flexhex.diagnosis.runs.blocks import torque_at

Array = NDArray[np.float64]
POOR = 0.5
"""Share of the torque's RMS that a model may leave unexplained."""
TOGETHER = 0.7
"""Least correlation of a torque with the nominal model's. Measured: -0.97 with a turned sign, 0.62
with two axes exchanged; 0.89 and more with another payload, stiffness, damping or offset."""
DELAYED = 2e-4
"""Delay [s] of the reported torques that is worth a word."""


def poor_axes(model: Calibrated, residual: Sequence[Array]) -> list[int]:
    """Axes (from 0) of which more than `POOR` of the torque is left."""
    left = axis_rms(model.blocks, residual)
    return [int(i) for i in np.flatnonzero(left > POOR * model.torque_rms)]


def strange_axes(model: Calibrated) -> list[int]:
    """Axes (from 0) whose torque does not go with that of the machine file's own parameters and
    the payloads of the fit.

    A fit may turn the sign of all inertias to please a log whose sign is turned; what it leaves
    then looks like effects.
    """
    carried = np.array([known.group == GROUP for known in model.known])
    nominal = np.where(carried, model.regression.q, model.nominal)
    tau = [torque_at(b, model.base.window, model.fitted.delay) for b in model.blocks]
    left = model.residual(nominal)
    usable = [b.usable for b in model.blocks]
    seen = np.concatenate([t[m] for t, m in zip(tau, usable, strict=True)])
    modelled = seen - np.concatenate([r[m] for r, m in zip(left, usable, strict=True)])
    seen, modelled = (v - v.mean(axis=0) for v in (seen, modelled))
    sizes = np.linalg.norm(seen, axis=0) * np.linalg.norm(modelled, axis=0)
    together = (seen * modelled).sum(axis=0) / np.maximum(sizes, 1e-300)
    return [int(i) for i in np.flatnonzero(together < TOGETHER)]


def delayed(fit: Joint, deviations: float) -> str:
    """What is said of the torques' common delay beside all that was found, or nothing: alone, the
    base model takes friction and cogging for a part of one. deviations: standard errors that it
    must stand above zero."""
    model = fit.bench.model
    place = next(i for i, known in enumerate(model.known) if known.group == "delay")
    late, deviation = (
        np.array([fit.q[place], fit.covariance[place, place] ** 0.5]) * model.scale[place]
    )
    if abs(late) < max(DELAYED, deviations * deviation):
        return ""
    where = " on all axes" if model.base.n > 1 else ""
    alone = "" if model.base.n > 1 else "; a single axis does not show whether its drive is late"
    verb = "lags" if late > 0 else "leads"
    return (
        f"the torque channel {verb} the angles by {1e3 * abs(late):.2g} ms{where}; treated as"
        f" logger delay and compensated{alone}"
    )


def sentence(axes: Sequence[int]) -> str:
    """What is said of such axes."""
    listed = ", ".join(str(i + 1) for i in axes)
    return (
        f"more than {POOR:.0%} of the torque of axis {listed} stays unexplained by all that"
        " was found: nothing is named there"
    )

"""Values of the base model from one fit to the next."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Base
from flexhex.diagnosis.jointfit.known import about_known
from flexhex.diagnosis.regression.calibrate import Calibrated
from flexhex.diagnosis.regression.fitted import Fitted
from flexhex.diagnosis.runs.blocks import Block
from flexhex.diagnosis.runs.noise import Noise
from flexhex.diagnosis.runs.span import LATEST

Array = NDArray[np.float64]


def tolerance_of_delay(base: Base, blocks: Sequence[Block]) -> float:
    """Standard deviation of the torques' common delay, before any fit [s]."""
    return base.late * max(block.run.tau.ts for block in blocks)


def at_values(model: Calibrated, fitted: Fitted) -> Calibrated:
    """The base model about other values, as sure of its parameters."""
    now = about_known(model.base, model.blocks, fitted, model.noise, (), model.errors)
    return now.as_sure(model)


def values_after(model: Calibrated, q: Array, stride: float = np.inf) -> Fitted:
    """The values after one Gauss-Newton step, to the coefficients q, kept within bounds.

    stride: largest step of a width, relative.
    """
    base, now = model.base, model.fitted
    step = q * model.scale
    n_p, n_c = len(base.linear), len(base.curved)
    nominal = np.array([k.nominal for k in base.widths])
    widths = nominal + step[n_p + n_c : n_p + n_c + len(nominal)]
    p = np.array([k.nominal for k in base.linear]) + step[:n_p]
    gains = np.array([k.nominal for k in base.curved]) + step[n_p : n_p + n_c]
    most = LATEST * now.late
    delay = now.expected + float(np.clip(step[n_p + n_c + len(nominal)], -most, most))
    widths = np.clip(widths, now.widths / (1 + stride), now.widths * (1 + stride))
    widths = np.clip(widths, 0.4 * nominal, 2.5 * nominal)
    loads = {load.name: step[model.places(load)] for load in model.loads}
    return replace(now, p=p, gains=gains, widths=widths, delay=delay, loads=loads)


def evenly_noisy(model: Calibrated, left: Sequence[Array]) -> Noise:
    """The noise, of each axis as many times larger as the model leaves more (m, n) [N m] of it than
    of the axis that it explains best, each relative to its noise."""
    white = [model.white(i, [own[:, i] for own in left]) for i in range(model.base.n)]
    size = np.array([max(float(np.sqrt((own**2).mean())), 1.0) for own in white])
    return replace(model.noise, scale=model.noise.scale * size / size.min())

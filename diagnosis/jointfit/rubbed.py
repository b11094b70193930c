"""Friction beside the base model: sensors and currents have one, and without it other parameters
and the delay take its place."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Known
from flexhex.diagnosis.regression.calibrate import Calibrated
from flexhex.diagnosis.regression.design import beside_of
from flexhex.diagnosis.runs.blocks import Block

Array = NDArray[np.float64]
SHARP = 0.05
"""Rate, relative to its RMS, at which dry friction is there."""


def with_friction(model: Calibrated) -> Calibrated:
    """The same with dry and viscous friction of each axis and a constant torque beside the base
    model."""
    n, columns = model.base.n, friction(model.blocks)
    kinds = ["dry", "viscous", "constant"]
    more = [
        Known(f"{kind}[{i + 1}]", "", 0.0, 1.0, "friction", i) for kind in kinds for i in range(n)
    ]
    torque = np.maximum(np.tile(model.torque_rms, len(kinds)), np.finfo(float).tiny)
    B = [beside_of(b, c * torque) for b, c in zip(model.B, columns, strict=True)]
    scale = np.concatenate([model.scale, np.ones(len(more))])
    return replace(model, known=(*model.known, *more), scale=scale, B=tuple(B))


def friction(blocks: Sequence[Block]) -> list[Array]:
    """Dry friction, viscous friction and a constant torque (m, n, 3 n) of each axis in columns of
    its own, of about one, of each block."""
    rates = np.concatenate([block.run.motion.thetad for block in blocks])
    rms = np.maximum(np.sqrt((rates**2).mean(axis=0)), np.finfo(float).tiny)
    columns = []
    for block in blocks:
        rate = block.run.motion.thetad / rms
        kinds = [block.smooth(v) for v in (np.tanh(rate / SHARP), rate, np.ones_like(rate))]
        own = [v[:, :, None] * np.eye(v.shape[1]) for v in kinds]
        columns.append(np.concatenate(own, axis=2))
    return columns

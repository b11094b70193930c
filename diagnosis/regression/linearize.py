"""Columns and torque of the base model about given nonlinear values."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Base, Known
from flexhex.diagnosis.regression.calibrate import Calibrated
from flexhex.diagnosis.regression.design import Design, beside_of
from flexhex.diagnosis.regression.fitted import Fitted
from flexhex.diagnosis.regression.payloads import carried, columns_of, loads_of
from flexhex.diagnosis.runs.blocks import Block, torque_at, torque_rate
from flexhex.diagnosis.runs.noise import Noise

Array = NDArray[np.float64]
HISTORY = 0.3
"""One standard deviation of a hysteresis' state at the start of a trajectory."""


def about(
    base: Base,
    blocks: Sequence[Block],
    fitted: Fitted,
    noise: Noise,
    ours: Sequence[Block] = (),
    given: Sequence[Array] = (),
    errors: Sequence[Array] = (),
) -> Calibrated:
    """Columns and torque about given nonlinear values.

    errors: columns of errors of the geometry, where they are known from another fit to these runs.
    given: torque (m, n) [N m] of each block that known effects explain already.
    ours: blocks of the fit, when these are others: the parameters are those of the fit, and its
    runs' history is not these's.
    """
    loads = loads_of(base, ours or blocks)
    listed = list(dict.fromkeys(block.run.trajectory for block in ours or blocks))
    histories = [
        Known(f"z_0[{i + 1}] of {name}", "1", 0.0, HISTORY, "history", i)
        for name in listed
        for i in range(len(base.curved))
    ]
    delay = Known("delay", "s", fitted.expected, fitted.late, "delay")
    wrong = base.geometry.known if base.geometry else ()
    payloads = [known for load in loads for known in load.known]
    known = (*base.linear, *base.curved, *base.widths, delay, *wrong, *histories, *payloads)
    scale = np.array([k.tolerance if np.isfinite(k.tolerance) else 1.0 for k in known])
    p0 = np.array([k.nominal for k in base.linear])
    c0 = np.array([k.nominal for k in base.curved])
    offset = fitted.widths - np.array([k.nominal for k in base.widths])
    ys, torques = list[Array](), list[Array]()
    Bs: list[Design] = []
    if base.geometry and not errors:
        errors = [
            base.geometry.columns(
                block.run.motion,
                block.weights,
                carried(base, loads, fitted.loads, block.run, fitted.p),
            )
            for block in blocks
        ]
    for k, block in enumerate(blocks):
        motion = block.run.motion
        curve, tangent = np.zeros((len(block.at), base.n, 0)), None
        if len(base.curved):
            z, by_width = base.bend(motion, fitted.widths)
            curve = _diagonal(block.smooth(z))
            tangent = _diagonal(block.smooth(by_width * fitted.gains))
        # of the torque as reported: that of the model would be full of the encoders' noise
        passed_on = 1.0 - fitted.losses
        rate = -torque_rate(block, base.window, fitted.delay) * passed_on
        parts = [curve, *([] if tangent is None else [tangent]), rate[:, :, None]]
        if errors:
            parts.append(errors[k])
        for name in listed if len(base.curved) else ():
            own = not ours and name == block.run.trajectory
            parts.append(_history(block, fitted) if own else np.zeros_like(curve))
        parts += columns_of(base, loads, block)
        torques.append(torque_at(block, base.window, fitted.delay))
        y = torques[-1] * passed_on - block.linear.times(base.loaded(p0, block.run.payload))
        y = y + rate * (fitted.delay - fitted.expected)
        if np.any(fitted.losses):
            # their columns are of the torque that the fit has the drives report
            p = carried(base, loads, fitted.loads, block.run, fitted.p)
            joint = block.linear.times(p) + curve @ fitted.gains
            y = y + fitted.losses * joint / passed_on
        if tangent is not None:
            y = y - curve @ c0 + tangent @ offset
        if given:
            y = y - given[k]
        Bs.append(_design(block, parts, scale))
        ys.append(y)
    whole = tuple(ys), tuple(Bs), tuple(errors)
    model = Calibrated(base, tuple(blocks), fitted, known, scale, *whole, noise)
    return replace(model, loads=loads, torque=tuple(torques))


def _design(block: Block, parts: Sequence[Array], scale: Array) -> Design:
    """The base model's columns of a block and others (m, n, k), each times its scale."""
    count = len(block.linear.unit)
    design = Design(count, block.linear.scaled(scale[:count]))
    return beside_of(design, np.concatenate(parts, axis=2) * scale[count:])


def _history(block: Block, fitted: Fitted) -> Array:
    """What the unknown state before the run leaves behind, forgotten on the way (m, n, n)."""
    theta = block.run.motion.theta
    travel = np.cumsum(np.abs(np.diff(theta, axis=0, prepend=theta[:1])), axis=0)
    return _diagonal(block.smooth(fitted.gains * np.exp(-travel / fitted.widths)))


def _diagonal(values: Array) -> Array:
    """(m, n) -> (m, n, n) with the values of axis i in its own column."""
    m, n = values.shape
    out = np.zeros((m, n, n))
    out[:, np.arange(n), np.arange(n)] = values
    return out

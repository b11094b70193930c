"""The base model fitted to the runs, with the effects that it has already."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from diagnosis.base import Base
from diagnosis.blocks import Block
from diagnosis.calibrate import Calibrated, Fitted, about
from diagnosis.candidates import known_torque
from diagnosis.noise import Noise, measured

STEPS = 2
"""Gauss-Newton steps."""


def calibrate(base: Base, blocks: Sequence[Block]) -> Calibrated:
    """Fit the base model: the linear part, then widths and delay by Gauss-Newton.

    What the effects that the model has already explain is taken off first.
    """
    fitted = Fitted(
        np.array([k.nominal for k in base.linear]),
        np.array([k.nominal for k in base.curved]),
        np.array([k.nominal for k in base.widths]),
        0.0,
    )
    flat = Noise(np.zeros((base.n, 2)), np.ones(base.n), np.ones(base.n), False)
    made = about(base, blocks, fitted, flat)
    given = known_torque(made)
    noise = measured(blocks, made.residual(made.regression.q))
    for _ in range(STEPS):
        made = about(base, blocks, fitted, noise, given=given)
        fitted = _moved(made)
    made = about(base, blocks, fitted, noise, given=given)
    noise = measured(blocks, made.residual(made.regression.q))
    return replace(made, noise=noise)


def _moved(made: Calibrated) -> Fitted:
    """The values after one Gauss-Newton step, kept within bounds."""
    base, now = made.base, made.fitted
    step = made.regression.q * made.scale
    n_p, n_c = len(base.linear), len(base.curved)
    nominal = np.array([k.nominal for k in base.widths])
    widths = nominal + step[n_p + n_c : n_p + n_c + len(nominal)]
    p = np.array([k.nominal for k in base.linear]) + step[:n_p]
    gains = np.array([k.nominal for k in base.curved]) + step[n_p : n_p + n_c]
    delay = float(np.clip(now.delay + step[n_p + n_c + len(nominal)], -0.005, 0.005))
    return Fitted(p, gains, np.clip(widths, 0.4 * nominal, 2.5 * nominal), delay)

"""What the effects that a model has already explain of the torque."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Base
from flexhex.diagnosis.hypotheses.candidates import Bench
from flexhex.diagnosis.hypotheses.compiled import compiled
from flexhex.diagnosis.regression.calibrate import Calibrated
from flexhex.diagnosis.regression.fitted import Fitted
from flexhex.diagnosis.regression.linearize import about
from flexhex.diagnosis.runs.blocks import Block
from flexhex.diagnosis.runs.noise import Noise
from flexhex.fmus.common.machine.effect_use import EffectUse

Array = NDArray[np.float64]


def known_torque(model: Calibrated, told: Sequence[EffectUse] = ()) -> list[Array]:
    """Torque (m, n) [N m] of each block that the model's own effects explain, or those that are
    `told`; [] for none."""
    uses = [use for use in told or model.base.given if use.axes]
    if not uses:
        return []
    bench = Bench(model, compiled(model.base.n, {use.id: use.effect for use in uses}))
    total = [np.zeros((len(block.at), model.base.n)) for block in model.blocks]
    for use in uses:
        for place, axis in enumerate(use.axes):
            gains = np.array([row[place] for row in use.gains])
            for k, values in enumerate(bench.thin(use.id, axis - 1, use.shape)):
                if values.ndim == 3:
                    total[k] += values @ gains
                else:
                    total[k][:, axis - 1] += values @ gains
    return total


def without_stated(model: Calibrated) -> Calibrated:
    """The same of the runs without the torque of what the file states."""
    told = model.base.stated.uses
    return model.less(known_torque(model, told)) if told else model


def about_known(
    base: Base,
    blocks: Sequence[Block],
    fitted: Fitted,
    noise: Noise,
    ours: Sequence[Block] = (),
    errors: Sequence[Array] = (),
) -> Calibrated:
    """`linearize.about`, with what the model's own effects explain taken off."""
    plain = about(base, blocks, fitted, noise, ours, (), errors)
    given = known_torque(plain)
    return about(base, blocks, fitted, noise, ours, given, plain.errors) if given else plain

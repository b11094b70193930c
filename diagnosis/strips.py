"""One run over time: measured torque beside what the model says before and after."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.jointfit.known import without_stated
from flexhex.diagnosis.regression.calibrate import Calibrated
from flexhex.diagnosis.result.pictured import Strip
from flexhex.diagnosis.runs.blocks import Block, torque_at
from flexhex.diagnosis.selection.side import Side

Array = NDArray[np.float64]


def strips(side: Side) -> tuple[Strip, ...]:
    """Of every axis: in the first held-out run, or in the first run where none was held out.

    The torque is smoothed by the window of the rows. Rows at which a channel is missing are NaN.
    """
    fit, others = side.fit, side.others
    model = fit.bench.model
    bare = without_stated(model)
    if others is not None and others.blocks:
        block, where = others.blocks[0], others.there
        before = others.without_stated().residual((), (), bare.regression.q)[0]
        after = others.residual(fit.parts, fit.beta, fit.q)[0]
    else:
        block, where = model.blocks[0], model
        before = bare.residual(bare.regression.q)[0]
        after = fit.residual[0]
    time = block.at + block.run.shift
    return tuple(
        Strip(block.run.name, others is not None, i + 1, kind.unit("N m"), time, *values)
        for i, kind in enumerate(fit.bench.scales.kinds)
        for values in [_sides(block, where, before[:, i], after[:, i], i)]
    )


def _sides(
    block: Block, model: Calibrated, before: Array, after: Array, axis: int
) -> tuple[Array, Array, Array]:
    """Measured torque of an axis, that of the model before, after (m,): none where it rests, as dry
    friction carries any torque there."""
    measured = torque_at(block, model.base.window, model.fitted.delay)[:, axis]
    measured = np.where(block.usable, measured, np.nan)
    judged = np.where(block.moves[:, axis], measured, np.nan)
    return measured, judged - before, judged - after

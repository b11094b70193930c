"""What is left of the torques of runs, with the file's parameters and with the estimates."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.estimation.estimate import Estimated
from flexhex.diagnosis.estimation.records import Errors
from flexhex.diagnosis.estimation.stated import file_torque
from flexhex.diagnosis.kinds import units_of
from flexhex.diagnosis.regression.calibrate import Calibrated
from flexhex.diagnosis.result.pictured import Strip
from flexhex.diagnosis.runs.blocks import torque_at

Array = NDArray[np.float64]


def errors(estimated: Estimated, there: Calibrated) -> Errors:
    """Over all runs of `there`, each axis by itself."""
    kept = [block.usable for block in there.blocks]

    def rms(parts: Sequence[Array]) -> Array:
        rows = np.concatenate([part[good] for part, good in zip(parts, kept, strict=True)])
        return np.asarray(np.sqrt((rows**2).mean(axis=0)))

    torque = rms(_torques(there))
    size = np.maximum(torque, np.finfo(float).tiny)
    file = rms(_with_file(estimated, there))
    return Errors(torque, file / size, rms(there.residual(estimated.q)) / size)


def strips(estimated: Estimated, there: Calibrated, held_out: bool) -> tuple[Strip, ...]:
    """The first run of `there` over time, axis by axis: measured, with the file's parameters and
    effects (before), with the estimates (after); NaN where the log has a gap."""
    block, measured = there.blocks[0], _torques(there)[0]
    left = _with_file(estimated, there)[0], there.residual(estimated.q)[0]
    gone = np.where(block.usable, 0.0, np.nan)[:, None]
    sides = [side + gone for side in (measured, *(measured - rest for rest in left))]
    units = units_of(there.base, there.base.n, "N m")
    time = block.at + block.run.shift
    return tuple(
        Strip(block.run.name, held_out, i + 1, unit, time, *(side[:, i] for side in sides))
        for i, unit in enumerate(units)
    )


def _with_file(estimated: Estimated, there: Calibrated) -> list[Array]:
    """What the file's parameters and effects leave (m, n) of each run."""
    own = file_torque(there, estimated.extras)
    return [left - torque for left, torque in zip(there.residual(there.nominal), own, strict=True)]


def _torques(there: Calibrated) -> list[Array]:
    """Smoothed torques (m, n) of each run, at the delay of the fit."""
    window, delay = there.base.window, there.fitted.delay
    return [torque_at(block, window, delay) for block in there.blocks]

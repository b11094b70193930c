"""Effects that a model's file states, in an identification: their gains are fitted anew with all
other parameters, friction and offset in the form that the runs show, others in the file's shape."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Base
from flexhex.diagnosis.estimation.extras import Extra, Extras
from flexhex.diagnosis.estimation.friction import PARAMETER
from flexhex.diagnosis.jointfit.known import known_torque
from flexhex.diagnosis.regression.calibrate import Calibrated

Array = NDArray[np.float64]


def with_stated(base: Base, more: Extras) -> Extras:
    """Effects that are fitted beside, with those of the file that no parameter of friction is."""
    listed, written = list(more.listed), dict[str, float]()
    for use in base.stated.uses:
        for axis, gains in zip(use.axes, np.transpose(use.gains).tolist(), strict=True):
            if use.id in PARAMETER:
                written[f"{PARAMETER[use.id]}[{axis}]"] = gains[0]
                continue
            there = [e for e in listed if (e.effect.id, e.axis) == (use.id, axis - 1)]
            same = next((e for e in there if e.shape == use.shape), None)
            if same is None:
                same = Extra(use.effect, axis - 1, use.shape, len(there) + 1, tuple(gains))
                listed.append(same)
            for gain, value in zip(use.effect.gains, gains, strict=True):
                written[same.parameter(gain.name)] = value
    changed = tuple(change for change in more.changed if change.parameter not in written)
    return replace(
        more, listed=tuple(listed), changed=changed, file=base.stated.uses, written=written
    )


def file_torque(there: Calibrated, more: Extras) -> Sequence[Array]:
    """Torque (m, n) of each block that they make with the file's values."""
    return known_torque(there, more.file) or [np.zeros_like(y) for y in there.y]

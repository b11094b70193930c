"""What columns are that noise is a part of, as far as the other passes tell.

A column of a measured torque's second derivative is mostly its noise where the motion is slow.
Products between passes leave that out, but it counts in the column's own square: the gain is then
too small, by as much as each trajectory is noisy, and what one says of it another denies. So the
column is replaced by what is expected of it, given what is seen (regression calibration, Carroll et
al., Measurement Error in Nonlinear Models, 2006): what the base model says of it, and of the rest
the part that repeats.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.selection.moments import Moments

Array = NDArray[np.float64]


def expected(moments: Moments, white: Mapping[int, Array]) -> Mapping[int, Array]:
    """Whitened columns (R, k) on each axis that feels them, without the part of each fold that does
    not repeat there beyond the base model."""
    rows, made = moments.rows, dict[int, Array]()
    step = moments.fit(None).solve(moments.pulled({i: rows.across(v) for i, v in white.items()}))
    for i, columns in white.items():
        beyond = columns - np.column_stack([moments.white(i, own) for own in step.T])
        twins, made[i] = rows.across(beyond), columns.copy()
        for part in rows.parts.values():
            whole = (beyond[part] ** 2).sum(axis=0)
            again = np.clip((beyond[part] * twins[part]).sum(axis=0), 0.0, whole)
            made[i][part] -= (1 - again / np.maximum(whole, np.finfo(float).tiny)) * beyond[part]
    return made

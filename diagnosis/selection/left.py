"""What a model explains of each axis' torque, and what it leaves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.selection.criteria import Criteria
from flexhex.diagnosis.selection.moments import Moments
from flexhex.diagnosis.selection.rows import Rows

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Rest:
    """What repeats of an axis' torque and is explained by nothing: relative RMS, how many standard
    errors it stands above zero, and what to explain all of it would gain at most [nats]."""

    size: float
    deviations: float
    gain: float = 0.0


def explained(plain: Moments, moments: Moments, criteria: Criteria) -> tuple[float, ...]:
    """Relative RMS of what the terms of a model add to each axis' torque, beside the same
    parameters of the base model, which plain has without terms."""
    alone = plain.loosened(list(moments.freed), criteria.loose**-2.0)
    q, before = moments.fit(None).q, alone.fit(None).q
    more = [moments.torque(i, q) - alone.torque(i, before) for i in range(moments.rows.n)]
    relative = np.sqrt([(v**2).mean() for v in more]) / moments.rows.torque_rms
    return tuple(relative.tolist())


def rest_of(moments: Moments) -> tuple[Rest, ...]:
    """What passes have in common of each axis in the fit to all folds, and nothing explains; of
    passes that did not move alike what is more than the noise that they show."""
    return tuple(rest_on(moments, i, moments.fit(None).q) for i in range(moments.rows.n))


def rest_on(
    moments: Moments, axis: int, q: Array, raw: Array | float = 0.0, white: Array | float = 0.0
) -> Rest:
    """The same of an axis beside coefficients (m,) of the model and another torque (R,) [N m],
    which is also given whitened."""
    rows = moments.rows
    left = rows.level(axis, rows.y[axis] - moments.torque(axis, q) - raw)
    whitened = rows.level(axis, rows.white_y[axis] - moments.white(axis, q) - white)
    both = _in_common if rows.pairs.nnz else _beyond_noise
    square, deviations, gain = both(rows, axis, left, whitened)
    return Rest(float(square**0.5 / rows.torque_rms[axis]), deviations, gain)


def _in_common(rows: Rows, axis: int, left: Array, white: Array) -> tuple[float, float, float]:
    """Mean square [N2 m2], standard errors and gain of what repeats, or comes again with the
    opposite sign, as an oscillation of its own may; left (R,) [N m], and whitened."""
    there, pairs = rows.moving[axis].astype(float), rows.pairs
    weight = float(there @ (pairs @ there)) or np.inf
    # whitened noise has a variance of one
    squares = abs(float(white @ (pairs @ white)))
    chance = float(np.sqrt(2.0 * (pairs.data**2).sum()) * rows.model.noise.chance[axis])
    return abs(float(left @ (pairs @ left))) / weight, squares / chance, squares / 2


def _beyond_noise(rows: Rows, axis: int, left: Array, white: Array) -> tuple[float, float, float]:
    """The same of what is more than the noise of passes; nothing where none was run twice."""
    noise, count = rows.model.noise, float(rows.moving[axis].sum())
    if not noise.repeats or not count:
        return 0.0, 0.0, 0.0
    square = max(float(left @ left) / count - float(noise.rms[axis]) ** 2, 0.0)
    squares = max(float(white @ white) - count, 0.0)
    return square, squares / float(np.sqrt(2.0 * count) * noise.chance[axis]), squares / 2

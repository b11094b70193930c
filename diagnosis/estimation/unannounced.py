"""A payload on some of the runs that no log announces: it would bend all parameters.

What is left of each run is compared with what a payload makes there. The runs are parted where the
sizes of these payloads are farthest apart, and all is fitted anew with a payload on the heavier
ones. It is kept if its mass is sure and it takes away a good part of what was left, to which little
remains: a model that lacks more lets anything look like a payload.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Base
from flexhex.diagnosis.estimation.estimate import Estimated, estimate
from flexhex.diagnosis.jointfit.leftover import axis_rms
from flexhex.diagnosis.result.verdict import LARGE, NORMAL
from flexhex.diagnosis.runs.run import Run

Array = NDArray[np.float64]
MASSIVE = ("kg", "kg m2")
"""Units of what no payload makes smaller: of the first that the base model has, its mass tells."""
SUSPECT = 0.25
"""Share of what is left of a run, in squares, that a payload must explain before one is tried. Runs
without one had up to 0.05, with one 0.8 and more (UR10e, simulated cart)."""
SURE, LOWER = 5.0, 0.8
"""Standard deviations by which its mass must be above zero (0.9 at most without a payload, 30 and
more with one), and what may be left of the mean square with it (0.997 and 0.1)."""


def with_payload(base: Base, runs: Sequence[Run], estimated: Estimated) -> tuple[Estimated, str]:
    """The fit with a payload on those runs that carry one, and a sentence; or as it was."""
    heavier = _heavier(estimated)
    if not heavier:
        return estimated, ""
    bit = 1 << max(run.loads for run in runs).bit_length()
    loaded = [replace(r, loads=r.loads | bit) if r.name in heavier else r for r in runs]
    again, _ = estimate(base, loaded, estimated.extras)
    mass = _mass(again)
    value, deviation = again.values[mass], np.sqrt(again.covariance[mass, mass])
    left, before = _left(again), _left(estimated)
    felt = left < LOWER * before
    if value < SURE * deviation or left.mean() > LOWER * before.mean():
        return estimated, ""
    if (left[felt] > LARGE**2).any():
        # what else is missing there may look like a payload
        return estimated, ""
    names = ", ".join(Path(name).name for name in heavier)
    verb = "carries" if len(heavier) == 1 else "carry"
    size = f"{value:.3g} ± {NORMAL * deviation:.2g} {again.known[mass].printed}"
    return again, (
        f"{names}: {verb} {size} more than the other runs, which no head announces:"
        " fitted as `payload`; write it into the heads of these logs, or leave them out"
    )


def _heavier(estimated: Estimated) -> list[str]:
    """Names of runs that may carry more than the others; none where nothing looks like it."""
    model = estimated.model
    places = list(model.base.payload)
    if not places or len(model.blocks) < 2:
        return []
    massive = _massive([model.base.linear[place].unit for place in places])
    if massive is None:
        return []
    rests = model.residual(estimated.q)
    weight = 1 / np.maximum(axis_rms(model.blocks, rests), np.finfo(float).tiny)
    sizes, shares = [], []
    for block, rest in zip(model.blocks, rests, strict=True):
        y = (rest * weight)[block.usable].ravel()
        A = block.linear.at(places) * weight[None, :, None]
        A = A[block.usable].reshape(len(y), -1)
        p = np.linalg.lstsq(A, y, rcond=1e-6)[0]
        sizes.append(float(p[massive]))
        whole = float(np.mean(y**2))
        shares.append(1 - float(np.mean((y - A @ p) ** 2)) / whole if whole else 0.0)
    if max(shares) < SUSPECT:
        return []
    order = np.sort(sizes)
    k = int(np.argmax(np.diff(order)))
    names = [block.run.name for block in model.blocks]
    return [n for n, size in zip(names, sizes, strict=True) if size > order[k]]


def _massive(units: Sequence[str]) -> int | None:
    return next((units.index(unit) for unit in MASSIVE if unit in units), None)


def _mass(estimated: Estimated) -> int:
    """Where the mass of the last payload stands among the parameters."""
    place = estimated.model.places(estimated.model.loads[-1])
    units = [known.unit for known in estimated.known[place]]
    return int(place.start) + (_massive(units) or 0)


def _left(estimated: Estimated) -> Array:
    """Mean square (n,) of what is left, relative to the torque of each axis."""
    rms = axis_rms(estimated.model.blocks, estimated.model.residual(estimated.q))
    return np.asarray((rms / np.maximum(estimated.model.torque_rms, np.finfo(float).tiny)) ** 2)

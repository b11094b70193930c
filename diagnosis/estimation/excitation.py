"""A motion that would tell more of the parameters than those of the logs, within what they show.

Of several multisines on all axes the one is taken that narrows base parameters and friction most:
with the information A of the runs (J^T J / s^2 and what the file says) and that of a motion, B, the
standard deviation of a sum c is expected to shrink by

    sqrt(c (A + B)^-1 c / c A^-1 c)

whose logarithms are summed up (the D-criterion of optimal design, of sums instead of parameters).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Motion
from flexhex.diagnosis.estimation.friction import GROUP as FRICTION
from flexhex.diagnosis.estimation.motion import differences
from flexhex.diagnosis.estimation.records import Identified
from flexhex.diagnosis.kinds import kinds_of
from flexhex.diagnosis.logs import Log
from flexhex.diagnosis.planning.experiment import Limits, make
from flexhex.diagnosis.planning.trajectory import Trajectory
from flexhex.diagnosis.regression.gram import safe_inverse
from flexhex.diagnosis.result.estimates import Parameter
from flexhex.diagnosis.runs.run import Run, TimeSeries
from flexhex.fmus.common.effects import Experiment

Array = NDArray[np.float64]
SECONDS = 20.0
"""Of a motion."""
TRIED = tuple(product((0.05, 0.1, 0.2), (3, 10), (1, 2, 3)))
"""Lowest frequency [Hz], number of sines, and seed of the phases of each motion that is tried: few
slow ones go far where the accelerations of the logs are low."""
FINEST = 2e-3
"""Sample time of a motion, at least [s]."""


@dataclass(frozen=True)
class Excitation:
    """A motion, and what it is expected to narrow: parameters and sums with their standard
    deviation now and after one more run along it, relative."""

    motion: Trajectory
    narrowed: tuple[tuple[Parameter, float], ...]


def excitation(identified: Identified) -> Excitation:
    """The best motion that was tried."""
    estimated = identified.estimated
    model, regression = estimated.model, estimated.regression
    limits = _limits(identified)
    ts = max(FINEST, model.blocks[0].run.motion.ts)
    A = np.diag(regression.prior) + regression.gram[0]
    places = {known.name: k for k, known in enumerate(estimated.known)}
    rubbing = [known.name for known in estimated.known if known.group == FRICTION]
    requested = [*identified.combinations, *(identified[name] for name in rubbing)]
    # what is left out of the fit has no columns to be narrowed
    fitted = {
        known.name for known, scale in zip(estimated.known, model.scale, strict=True) if scale
    }
    requested = [one for one in requested if fitted.issuperset(name for name, _ in one.terms)]
    C = np.zeros((len(requested), len(A)))
    for row, one in zip(C, requested, strict=True):
        for name, factor in one.terms:
            row[places[name]] = factor * model.scale[places[name]]
    now = _spread(A, regression.prior, C)
    tried = []
    for base, sines, seed in TRIED:
        spec = Experiment(
            "multisine", {"f_base": base, "seed": seed, "duration": SECONDS, "n_sines": sines}
        )
        motion = make(spec, limits, ts, "next")
        more = _information(identified, motion)
        shrunk = _spread(A + more, regression.prior, C) / now
        tried.append((float(np.log(shrunk).sum()), shrunk, motion))
    _, shrunk, motion = min(tried, key=lambda one: one[0])
    order = np.argsort(shrunk)
    return Excitation(motion, tuple((requested[k], float(shrunk[k])) for k in order))


def _spread(A: Array, prior: Array, C: Array) -> Array:
    """Standard deviations of the sums C, but for a common factor."""
    inverse = safe_inverse(A, prior)
    return np.asarray(np.sqrt(np.maximum(np.einsum("ij,jk,ik->i", C, inverse, C), 1e-300)))


def _information(identified: Identified, motion: Trajectory) -> Array:
    """What one run along a motion adds to the normal matrix (nb, nb)."""
    theta = motion.r
    rate, acceleration = differences(theta, motion.ts)
    moved = Motion(0.0, motion.ts, theta[1:-1], rate, acceleration)
    valid = np.ones(len(rate), dtype=bool)
    run = Run("next", "next", moved, valid, TimeSeries(0.0, motion.ts, np.zeros_like(rate), valid))
    there = identified.estimated.along([run]).regression
    return there.gram[0]


def _limits(identified: Identified) -> Limits:
    """What the logs have shown to be possible."""
    model = identified.estimated.model
    motions = [block.run.motion for block in model.blocks]
    logs = [Log.of(str(k), m.ts, m.theta, m.theta) for k, m in enumerate(motions)]
    return replace(Limits.of_logs(logs), kinds=kinds_of(model.base, model.base.n))

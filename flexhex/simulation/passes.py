"""The last row of Table I: what three passes of one trajectory do not have in common.

    repeatable part: the mean over the passes;  non-repeatable: the deviation from it
    RMS of the deviation, times sqrt(n / (n - 1)) since the mean is taken from the same n passes

[SH, V-A] case 4, from the data of case 2 (fixed feedforward).
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from numpy.typing import NDArray

from flexhex.fmus.common.machine.machine import Machine
from flexhex.simulation.cases import SETTLE, Case, table_cases
from flexhex.simulation.metrics import POSE_EVERY, Figures, end_effector_error
from flexhex.ssp.results import Result

Array = NDArray[np.float64]
PASSES = 3


def repeated_case(machine: Machine, p: Array, seconds: float) -> Case:
    """Fixed feedforward, the trajectory of `seconds` run through three times."""
    fixed = next(c for c in table_cases(machine, p, seconds) if c.name == "fixed")
    starts = dict(fixed.starts)
    starts["reference"] = {**starts["reference"], "passes": float(PASSES)}
    return dataclasses.replace(
        fixed,
        name="repeatability",
        title="non-repeatable part",
        duration=SETTLE + PASSES * seconds,
        starts=starts,
    )


def non_repeatable(values: Array, passes: int = PASSES) -> Array:
    """RMS of every column's deviation from the mean over the passes; values (samples, n)."""
    length = len(values) // passes
    by_pass = values[: passes * length].reshape(passes, length, -1)
    deviation = by_pass - by_pass.mean(axis=0)
    return np.asarray(np.sqrt((deviation**2).mean(axis=(0, 1)) * passes / (passes - 1)))


def repeatability_figures(machine: Machine, result: Result) -> Figures:
    """Figures of the non-repeatable part of a run of `repeated_case`, in Table I's units."""
    group = result.group("plant.theta")
    first = math.ceil(SETTLE / group.Ts - 1e-9)
    e = group.signals["feedback.e"][first:]
    e_rms = np.sqrt((non_repeatable(e) ** 2).mean())
    tau_rms = np.sqrt((non_repeatable(group.signals["feedback.tau_fb"][first:]) ** 2).mean())
    if not machine.has_platform:
        return Figures(float(e_rms) * 1e6, float(tau_rms), *[np.nan] * 6)
    length = len(e) // PASSES // POSE_EVERY * POSE_EVERY * PASSES
    theta = group.signals["plant.theta"][first : first + length]
    pose = end_effector_error(machine, theta[::POSE_EVERY], e[:length:POSE_EVERY])
    return Figures(float(e_rms) * 1e6, float(tau_rms), *(non_repeatable(pose) * 1e6).tolist())


def repeatable_share(repeated: Figures, adaptive: Figures) -> float:
    """Share of the adaptive run's feedback torque that repeats, of RMS values, [SH, V-B]."""
    return 1 - repeated.tau_fb / adaptive.tau_fb

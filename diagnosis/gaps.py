"""The gap before and after, per axis: on the runs of the fit and on the locked ones."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.jointfit.answer import axis_rms, repeat_rms
from flexhex.diagnosis.kinds import units_of
from flexhex.diagnosis.result.verdict import Gap
from flexhex.diagnosis.runs.noise import measured
from flexhex.diagnosis.selection.criteria import USUAL
from flexhex.diagnosis.selection.side import Side

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Before:
    """What the base model alone leaves (n,) [N m]: torque, for comparison; nominal, with the
    parameters of the file, NaN where it has none; fitted; repeat, of that; judged, both on the
    locked runs."""

    torque: Array
    nominal: Array
    fitted: Array
    repeat: Array
    judged: Mapping[str, Array]


def before_of(side: Side) -> Before:
    """Of the base model that a side was searched beside."""
    made, others = side.held.bench.made, side.others
    plain, bare = made.regression.q, made.nominal
    judged: dict[str, Array] = {}
    if others is not None:
        judged = {
            "nominal": axis_rms(others.blocks, others.residual((), (), bare)),
            "before": axis_rms(others.blocks, others.residual((), (), plain)),
        }
    nominal, fitted = (axis_rms(made.blocks, made.residual(q)) for q in (bare, plain))
    if not any(known.nominal for known in made.known):
        nominal = np.full(made.base.n, np.nan)
    repeat, _ = repeat_rms(made, made.residual(plain))
    return Before(made.torque_rms, nominal, fitted, repeat, judged)


def gap_of(before: Before, side: Side) -> Gap:
    """Before, and after what a side found."""
    held, made = side.held, side.held.bench.made
    repeat, _ = repeat_rms(made, held.residual)
    floor = np.full(made.base.n, np.nan)
    if made.noise.repeats:
        floor = measured(made.blocks, held.residual).floor
    judged = dict(before.judged)
    if side.others is not None:
        others = side.others
        left = others.residual(held.parts, held.beta, held.q)
        own = measured(others.blocks, left)
        judged["after"] = axis_rms(others.blocks, left)
        if own.repeats:
            judged["floor"] = own.floor
    after = axis_rms(made.blocks, held.residual)
    usual = before.torque, before.nominal, before.fitted, after
    return Gap(
        units_of(made.base, made.base.n, "N m"), *usual, floor, before.repeat, repeat, judged
    )


def slow(gap: Gap, rests: Mapping[int, float]) -> list[str]:
    """A sentence for each axis on which offsets and slopes of whole runs repeat by more than all
    that does not repeat. rests: RMS of what repeats beside them, by axis (from 0)."""
    found = list[str]()
    for i, rest in rests.items():
        left = float(np.sqrt(max(gap.repeat_after[i] ** 2 - rest**2, 0.0)))
        if left > max(gap.floor[i], USUAL.smallest_rest * gap.torque[i]):
            found.append(
                f"axis {i + 1}: an offset or slope of whole runs is left, {left:.2g}"
                f" {gap.units[i]}: a drift between them, or something slow that the model lacks"
            )
    return found

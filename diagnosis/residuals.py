"""The residual before and after, per axis: on the runs of the fit and on the held-out ones."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.jointfit.elsewhere import Elsewhere
from flexhex.diagnosis.jointfit.known import without_stated
from flexhex.diagnosis.jointfit.leftover import axis_rms, repeat_rms
from flexhex.diagnosis.kinds import axes_named, units_of
from flexhex.diagnosis.regression.calibrate import Calibrated
from flexhex.diagnosis.result.verdict import Residual
from flexhex.diagnosis.runs.blocks import Block, torque_rms
from flexhex.diagnosis.runs.noise import line, measured
from flexhex.diagnosis.selection.criteria import USUAL
from flexhex.diagnosis.selection.side import Side

Array = NDArray[np.float64]
RESTS = 0.05
"""Share of the time that an axis rests which is worth a word."""


@dataclass(frozen=True)
class Before:
    """What the base model alone leaves (n,) [N m]: torque, for comparison; nominal, with the
    parameters of the file, NaN where it has none; fitted; repeatable, of that; judged, both on the
    held-out runs."""

    torque: Array
    nominal: Array
    fitted: Array
    repeatable: Array
    judged: Mapping[str, Array]


def before_of(model: Calibrated, others: Elsewhere | None) -> Before:
    """Of a base model with what its file states, on its own runs and on others."""
    model, others = without_stated(model), others and others.without_stated()
    plain, bare = model.regression.q, model.nominal
    judged: dict[str, Array] = {}
    if others is not None:
        judged = {
            "nominal": axis_rms(others.blocks, others.residual((), (), bare)),
            "before": axis_rms(others.blocks, others.residual((), (), plain)),
            "torque": torque_rms(others.blocks),
        }
    nominal, fitted = (axis_rms(model.blocks, model.residual(q)) for q in (bare, plain))
    if not any(known.nominal for known in model.known):
        nominal = np.full(model.base.n, np.nan)
    repeatable, _ = repeat_rms(model, model.residual(plain))
    return Before(model.torque_rms, nominal, fitted, repeatable, judged)


def residual_of(before: Before, side: Side) -> Residual:
    """Before, and after what a side found."""
    fit, model = side.fit, side.fit.bench.model
    repeatable, _ = repeat_rms(model, fit.residual)
    resting = at_rest(model.blocks if side.others is None else side.others.blocks)
    non_repeatable = np.full(model.base.n, np.nan)
    if model.noise.repeats:
        non_repeatable = measured(model.blocks, fit.residual).rms
    judged = dict(before.judged)
    if side.others is not None:
        others = side.others
        left = others.residual(fit.parts, fit.beta, fit.q)
        own = measured(others.blocks, left)
        judged["after"] = axis_rms(others.blocks, left)
        if own.repeats:
            judged["non_repeatable"] = own.rms
    after = axis_rms(model.blocks, fit.residual)
    usual = before.torque, before.nominal, before.fitted, after
    return Residual(
        units_of(model.base, model.base.n, "N m"),
        *usual,
        non_repeatable,
        before.repeatable,
        repeatable,
        judged,
        resting,
    )


def unmoved(residual: Residual) -> Residual:
    """Where nothing was found that the model has not: after is before."""
    held_out = residual.held_out
    held_out = {**held_out, "after": held_out["before"]} if held_out else held_out
    return replace(
        residual,
        after=residual.before,
        repeatable_after=residual.repeatable,
        held_out=held_out,
    )


def at_rest(blocks: Sequence[Block]) -> Array:
    """Share (n,) of the usable rows in which each axis rests."""
    usable = sum(int(b.usable.sum()) for b in blocks)
    return np.asarray(1 - sum(b.judged.sum(axis=0) for b in blocks) / max(usable, 1))


def resting(residual: Residual) -> list[str]:
    """A sentence on the axes that rest for a part of the runs, or none."""
    axes = [i for i, share in enumerate(residual.resting) if share > RESTS]
    if not axes:
        return []
    one, several = len(axes) == 1, ", ".join(str(i + 1) for i in axes)
    ends = dict.fromkeys(f"{end(residual.resting[axes]):.0%}" for end in (np.min, np.max))
    shares, runs = " to ".join(ends), "held-out runs" if residual.held_out else "time"
    return [
        f"{'axis' if one else 'axes'} {several} {'rests' if one else 'rest'} for {shares} of the"
        f" {runs}: these samples are left out, as dry friction carries any torque at rest"
    ]


def slow(residual: Residual, steady: Array) -> list[str]:
    """A sentence on the axes on which offsets and slopes of whole runs repeat by more than all that
    does not repeat, or none. steady: RMS (n,) of what repeats beside them, see `levelled`."""
    sizes = dict[int, float]()
    for i, rest in enumerate(steady):
        left = float(np.sqrt(max(residual.repeatable_after[i] ** 2 - rest**2, 0.0)))
        if left > max(residual.non_repeatable[i], USUAL.smallest_rest * residual.torque[i]):
            sizes[i] = left
    listed = ", ".join(f"{left:.2g} {residual.units[i]}" for i, left in sizes.items())
    why = "a drift between them, or something slow that the model lacks"
    if not sizes:
        return []
    what = "an offset or slope of whole runs is"
    what = what if len(sizes) == 1 else "offsets or slopes of whole runs are"
    return [f"{axes_named(sizes)}: {what} left, {listed}: {why}"]


def levelled(side: Side) -> Array:
    """RMS (n,) of what repeats of what a side leaves, beside a straight line through each run."""
    model, runs = side.fit.bench.model, list[Array]()
    for block, kept, left in zip(model.blocks, model.kept, side.fit.residual, strict=True):
        lines = [line(good) for good in (kept[:, None] & block.moves).T]
        runs.append(left - np.stack([b @ (b.T @ v) for b, v in zip(lines, left.T, strict=True)], 1))
    return repeat_rms(model, runs)[0]


def unseen(residual: Residual, told: Collection[int]) -> list[str]:
    """A sentence on the axes on which the held-out runs repeat more than all that does not repeat,
    and more of their torque than the runs of the fit do, or none. told: axes (from 0) of which
    something is said already."""
    held_out, sizes = residual.held_out, dict[int, float]()
    if "non_repeatable" not in held_out:
        return []
    for i in (axis for axis in range(len(residual.units)) if axis not in told):
        noise, torque = held_out["non_repeatable"][i], held_out["torque"][i]
        left = float(np.sqrt(max(held_out["after"][i] ** 2 - noise**2, 0.0)))
        shown = residual.repeatable_after[i] / residual.torque[i]
        if left > max(noise, torque * max(USUAL.smallest_rest, shown)):
            sizes[i] = left
    if not sizes:
        return []
    listed = ", ".join(f"{left:.2g} {residual.units[i]}" for i, left in sizes.items())
    return [
        f"{axes_named(sizes)}: the held-out runs leave {listed} that repeats and that the runs of"
        " the fit do not show: give some of them as runs of the fit, too"
    ]

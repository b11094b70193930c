"""What changes from run to run: it goes on where a run ends, and drops out between passes."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import replace
from math import log

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.hypotheses.candidates import Bench
from flexhex.diagnosis.hypotheses.compiled import compiled
from flexhex.diagnosis.jointfit.answer import Joint, again, drifting, torque_of
from flexhex.diagnosis.jointfit.beside import beside
from flexhex.diagnosis.jointfit.elsewhere import Elsewhere
from flexhex.diagnosis.jointfit.known import about_known
from flexhex.diagnosis.regression.calibrate import Calibrated
from flexhex.diagnosis.result.naming import named_of
from flexhex.diagnosis.runs.blocks import LEAST, Block, blocks
from flexhex.diagnosis.runs.noise import measured
from flexhex.diagnosis.runs.run import Run
from flexhex.diagnosis.runs.span import JUDGED
from flexhex.diagnosis.selection.bars import Bars, beyond_chance, repeated, shown
from flexhex.diagnosis.selection.choose import (
    Accepted,
    best_first,
    effect_scores,
    one_cause,
    simplest,
)
from flexhex.diagnosis.selection.criteria import USUAL, Criteria
from flexhex.diagnosis.selection.firm import errors_of, firm
from flexhex.diagnosis.selection.generic_scores import generic_score
from flexhex.diagnosis.selection.hypotheses import Hypotheses
from flexhex.diagnosis.selection.hypothesis import ColumnsByAxis
from flexhex.diagnosis.selection.rows import Rows
from flexhex.diagnosis.selection.scores import Score
from flexhex.diagnosis.selection.side import Side
from flexhex.diagnosis.selection.unnamed import NamelessHypothesis, nameless
from flexhex.diagnosis.selection.unrefuted import refuted
from flexhex.fmus.common.effects import library

Array = NDArray[np.float64]
DRIFTS = ("thermal_drift", "offset_drift")
"""Effects that go on from run to run."""
SLOWER = 8.0
"""So much longer than usual torque and columns are smoothed for them."""


def drifts_of(first: Side, judged: Sequence[Run], criteria: Criteria = USUAL) -> list[Side]:
    """What changes from run to run, and so drops out between passes.

    Offsets wander without being a drift: one is named that predicts the runs of left-out
    trajectories better than an offset of its own for each run, or a random walk, and does not make
    held-out runs worse. What repeats and nothing explains may be taken for one: it is none if that
    still remains without it.
    """
    model = first.fit.bench.model
    if not model.noise.repeats:
        return []
    known = {name: library()[name] for name in DRIFTS}
    model = _slowly(first.fit, first.others)
    bench = Bench(model, compiled(model.base.n, known), across=True)
    rows = Rows.of(model)
    if len(rows.folds) < 2:
        return []
    hypotheses = Hypotheses(bench, rows)
    kept = _beyond_wander(hypotheses, criteria)
    kept, fit = firm(bench, one_cause(kept), criteria)
    others = None
    if judged and kept:
        others = Elsewhere(fit.bench, blocks(model.base, judged, model.spacing, JUDGED))
        worse, _ = refuted(fit, others)
        left = [a for a in kept if a.score.hypothesis.axis not in worse]
        kept, fit = (kept, fit) if len(left) == len(kept) else firm(bench, left, criteria)
    named = named_of(fit, errors_of(kept, criteria))
    return [Side(fit, others, tuple(named))] if named else []


def _beyond_wander(hypotheses: Hypotheses, criteria: Criteria) -> list[Accepted]:
    """The drift of each axis that predicts better than offsets that wander; one that another axis
    has is no surprise."""
    rows, kept = hypotheses.rows, dict[int, Accepted]()
    first, again = log(rows.n * len(DRIFTS) / criteria.false_alarms), log(criteria.odds * rows.n)
    listed = dict[int, tuple[Bars, list[Score]]]()
    for axis in range(rows.n):
        wanders = [_offsets(rows, axis), _walk(rows, axis)]
        least = max(generic_score(hypotheses.moments, wanders).gain, 0.0)
        scores = best_first(effect_scores(hypotheses.moments, hypotheses, (), criteria, [axis]))
        listed[axis] = Bars(least + first, least + again), scores
    while True:
        known, before = [each.score for each in kept.values()], len(kept)
        for axis, (bars, scores) in listed.items():
            good = [s for s in scores if beyond_chance(s, known, bars, criteria)]
            if axis not in kept and good and shown(good[0], criteria, repeated(good[0], known)):
                kept[axis] = simplest(good[0], good, 1, criteria)
        if len(kept) == before:
            return [kept[axis] for axis in sorted(kept)]


def _offsets(rows: Rows, axis: int) -> NamelessHypothesis:
    """An offset of all runs, and one of its own for each."""
    count = len(rows.model.blocks)
    own = [
        np.tile(rows.torque_rms[axis] * np.eye(count)[k], (len(block.at), 1))
        for k, block in enumerate(rows.model.blocks)
    ]
    columns = ColumnsByAxis({axis: rows.raw(own)}, {axis: rows.white(axis, own)})
    ways = np.linalg.cholesky(np.ones((count, count)) + np.eye(count))
    return nameless(axis, "offsets", columns, (np.asarray(ways),))


def _walk(rows: Rows, axis: int) -> NamelessHypothesis:
    """A random walk of the offset, from anywhere, from run to run and within each: a straight line
    from the start of a run to its end, and to the next one's."""
    runs = [block.run for block in rows.model.blocks]
    clocks = [b.at + b.run.shift - b.run.motion.t0 + b.run.start for b in rows.model.blocks]
    ends = [t for run in runs for t in (run.start, run.start + run.motion.ts * len(run.valid))]
    knots = np.unique(ends) - min(ends)
    hats = np.eye(len(knots)) * rows.torque_rms[axis]
    listed = [
        np.stack([np.interp(clock - min(ends), knots, hat) for hat in hats], axis=1)
        for clock in clocks
    ]
    columns = ColumnsByAxis({axis: rows.raw(listed)}, {axis: rows.white(axis, listed)})
    far = np.minimum.outer(knots, knots) / knots[-1]
    return nameless(axis, "walk", columns, (np.linalg.cholesky(1.0 + far),))


def without(fit: Joint, drift: Joint) -> Calibrated:
    """The base model of a fit, fitted anew beside the same effects to runs without a drift.

    Of a drift that slows down some repeats, as if the mechanism lacked it; and beside what a drift
    leaves, a delay explains too little to be one.
    """
    old = fit.bench.model
    pairs = zip(old.blocks, drifting(old, drift), strict=True)
    calm = [replace(block, drift=torque) for block, torque in pairs]
    model = replace(about_known(old.base, calm, old.fitted, old.noise), off=old.off)
    return beside(again(fit, Bench(model, list(fit.bench.effects.values()))))


def _slowly(fit: Joint, others: Elsewhere | None) -> Calibrated:
    """What a fit leaves, smoothed for what is slow: noise of the angles, which a longer window
    takes away, would make a drift that goes with the torque too small.

    others: held-out runs, of which enough must be left too.
    """
    old = fit.bench.model
    spans = [_seconds(block) / LEAST for block in old.blocks]
    spans += [_seconds(block) / (2 * JUDGED) for block in others.blocks] if others else []
    factor = max(1.0, min(SLOWER, min(spans) / old.base.spacing))
    base = copy(old.base)
    base.window, base.spacing = factor * base.window, factor * base.spacing
    listed = blocks(base, [block.run for block in old.blocks], factor * old.spacing, JUDGED)
    model = about_known(base, listed, old.fitted, old.noise)
    bench = Bench(model, list(fit.bench.effects.values()))
    explained = torque_of(bench, fit.parts, fit.beta)
    y = tuple(y - e for y, e in zip(model.y, explained, strict=True))
    model = replace(model, y=y, between=False)
    return replace(model, noise=measured(listed, _level(listed, model.residual(fit.q))))


def _seconds(block: Block) -> float:
    return float(block.at[-1] - block.at[0])


def _level(listed: Sequence[Block], residual: Sequence[Array]) -> list[Array]:
    """Residuals (m, n) [N m] of each block without what a straight line through it explains: else
    the drift, by which passes differ, would be a part of the noise."""
    levelled = []
    for block, values in zip(listed, residual, strict=True):
        clock = np.stack([np.ones(len(block.at)), block.at - block.at[0]], axis=1)
        good = block.usable
        line = np.linalg.lstsq(clock[good], values[good], rcond=None)[0]
        levelled.append(values - clock @ line)
    return levelled

"""A payload that came or went between runs: which runs had it, and what it predicts.

Which runs: `levels_of` says it, before anything is scored; in how many ways they could have been
parted counts against it.

Passes with and without the payload are no repeats of one another: products between them would take
the payload for noise. It is scored in another likelihood of the same runs, the one that they have
once it is accepted: the base model fitted anew, passes paired with passes of the same load alone,
the noise measured between those. What the payload adds to the log density of a left-out trajectory
is the difference between this likelihood with its columns and without them. Where no pass has
another one of its load the products are those within passes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.calibrate import Calibrated
from flexhex.diagnosis.candidates import Bench
from flexhex.diagnosis.fit import calibrate
from flexhex.diagnosis.selection.criteria import Criteria
from flexhex.diagnosis.selection.evidence import products
from flexhex.diagnosis.selection.hypotheses import (
    ChangedParameter,
    EffectHypothesis,
    Hypotheses,
    Payload,
)
from flexhex.diagnosis.selection.levels import Levels, levels_of, partitions
from flexhex.diagnosis.selection.moments import Left, Moments
from flexhex.diagnosis.selection.rows import Rows
from flexhex.diagnosis.selection.scores import Score, effect_term, size_of

Array = NDArray[np.float64]
MASSIVE = ("kg", "kg m2")
"""Units of parameters that no payload makes smaller: the first one that the base model has."""


def payload_score(
    moments: Moments, hypotheses: Hypotheses, known: Sequence[Score], criteria: Criteria
) -> Score | None:
    """A payload on some of the runs, on left-out folds; None where runs do not fall into
    levels."""
    levels = levels_of(moments, criteria)
    if levels is None:
        return None
    bench = _loaded(hypotheses, levels)
    rows = Rows.of(bench.made)
    found = bench.made.loads[-int(levels.max()) :]
    count = len(found) * len(bench.made.base.payload)
    without, columns = _apart(rows, count)
    plain = _with_known(Moments(without), Hypotheses(bench, without), known, criteria)
    carrying = tuple(b.run.name for b in bench.made.blocks if any(x.on(b.run) for x in found))
    choices = partitions(len(levels), len(found) + 1)
    by_fold, size = _predicted(plain, columns)
    return Score(Payload(bench, carrying, count, choices), by_fold, size)


def _loaded(hypotheses: Hypotheses, levels: Levels) -> Bench:
    """The base model fitted to runs of several levels, each but the lightest a payload; the last
    one is kept."""
    bench, found = hypotheses.bench, hypotheses.loaded
    key = tuple(int(level) for level in levels)
    if key not in found:
        made = _calibrated(bench.made, levels)
        load = made.loads[-1]
        deltas = zip(load.known, made.fitted.loads[load.name], strict=True)
        sized = [(k.unit, delta / k.tolerance) for k, delta in deltas if k.tolerance]
        unit = next(unit for unit in MASSIVE if any(unit == own for own, _ in sized))
        if sum(size for own, size in sized if own == unit) < 0:
            made = _calibrated(bench.made, _turned(levels, made))
        made.forget()
        found.clear()
        found[key] = bench.beside(made)
    return found[key]


def _turned(levels: Levels, made: Calibrated) -> Levels:
    """The heaviest as the lightest, among runs that carried the same before."""
    bits = len({load.bit for load in made.loads} - {None}) - int(levels.max())
    before = np.array([block.run.loads & (1 << bits) - 1 for block in made.blocks])
    return np.where(before == before[levels > 0][0], levels.max() - levels, levels)


def _calibrated(made: Calibrated, levels: Levels) -> Calibrated:
    bit = max(block.run.loads for block in made.blocks).bit_length()
    blocks = [
        replace(b, run=replace(b.run, loads=b.run.loads | (1 << bit + level - 1 if level else 0)))
        for b, level in zip(made.blocks, levels.tolist(), strict=True)
    ]
    return calibrate(made.base, blocks)


def _apart(rows: Rows, count: int) -> tuple[Rows, EffectHypothesis]:
    """Rows without the last `count` columns of the base model, and these."""
    without = replace(
        rows,
        B=tuple(B[:, :-count] for B in rows.B),
        white_B=tuple(B[:, :-count] for B in rows.white_B),
        prior=rows.prior[:-count],
    )
    raw = {i: B[None, :, -count:] for i, B in enumerate(rows.B)}
    white = {i: B[None, :, -count:] for i, B in enumerate(rows.white_B)}
    low = np.full(count, -np.inf)
    return without, EffectHypothesis("payload", None, ({},), raw, white, low, count, "", False, 1)


def _with_known(
    moments: Moments, hypotheses: Hypotheses, known: Sequence[Score], criteria: Criteria
) -> Moments:
    """The model with what was accepted, in these rows."""
    for score in known:
        hypothesis = score.hypothesis
        if isinstance(hypothesis, ChangedParameter):
            moments = moments.loosened(hypothesis.places, criteria.loose**-2.0)
        elif isinstance(hypothesis, EffectHypothesis):
            shaped = hypotheses.shaped(hypothesis, hypothesis.shapes[score.shape])
            moments = moments.extended(effect_term(moments, shaped, 0))
    return moments


def _predicted(moments: Moments, columns: EffectHypothesis) -> tuple[Array, float]:
    """What the payload's columns, with the tolerances of a payload, add to the log density of each
    fold (folds,) [nats]; relative RMS of their torque beyond what the model takes up."""
    total: dict[Left, float] = {}
    size = 0.0
    for left in [None, *moments.rows.folds]:
        fit, found = moments.fit(left), products(moments, columns, left)
        moved = fit.solve(found.cross)
        S = found.own[0] - found.cross.T @ moved
        A, r = (S + S.T) / 2 + np.eye(columns.width), found.right - found.cross.T @ fit.q
        gains = np.linalg.solve(A, r)
        total[left] = float(r @ gains - np.linalg.slogdet(A)[1]) / 2
        if left is None:
            torque = {i: raw[0] @ gains for i, raw in columns.raw.items()}
            size = size_of(moments, -(moved @ gains), torque)
    return np.array([total[None] - total[fold] for fold in moments.rows.folds]), size

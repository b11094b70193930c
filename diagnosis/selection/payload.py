"""A payload that came or went between runs: which runs had it, and what it predicts.

Runs are sorted by the amount of payload that each shows beside the model, and cut in two. Errors of
a run go together, so the two halves must stand apart by more than runs of one half do: an F test
over runs, for as many cuts as there are.

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
from scipy.stats import f as f_distribution

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
from flexhex.diagnosis.selection.moments import Left, Moments
from flexhex.diagnosis.selection.rows import Rows
from flexhex.diagnosis.selection.scores import Score, effect_term, size_of

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
SHARE = 0.01
"""Weight of the mean run in the amount of payload of a run, which may excite too little of it."""
MASSIVE = ("kg", "kg m2")
"""Units of parameters that no payload makes smaller: the first one that the base model has."""


def payload_score(
    moments: Moments, hypotheses: Hypotheses, known: Sequence[Score], criteria: Criteria
) -> Score | None:
    """A payload on some of the runs, on left-out folds; None where runs do not fall into two."""
    heavy = two_loads(moments, criteria)
    if heavy is None:
        return None
    bench = _loaded(hypotheses, heavy)
    rows = Rows.of(bench.made)
    count = len(bench.made.base.payload)
    without, columns = _apart(rows, count)
    plain = _with_known(Moments(without), Hypotheses(bench, without), known, criteria)
    choices = 2 ** (len(heavy) - 1) - 1
    load = bench.made.loads[-1]
    carrying = tuple(b.run.name for b in bench.made.blocks if load.on(b.run))
    by_fold, size = _predicted(plain, columns)
    return Score(Payload(bench, carrying, count, choices), by_fold, size)


def two_loads(moments: Moments, criteria: Criteria) -> Mask | None:
    """Runs (runs,) that carry more than the others, or less, if they surely do."""
    if not moments.rows.made.base.payload:
        return None
    amounts = _amounts(moments)
    count = len(amounts)
    names = [block.run.trajectory for block in moments.rows.made.blocks]
    which = np.unique(names, return_inverse=True)[1]
    own = np.array([amounts[which == w].mean(axis=0) for w in which])
    found = list[tuple[float, Mask]]()
    # trajectories differ in what the model lacks: their passes may show the payload alone
    for spread in (amounts - amounts.mean(axis=0), amounts - own):
        direction = np.linalg.svd(spread, full_matrices=False)[2][0]
        heavy = _cut(spread @ direction)
        found.append((_chance(amounts @ direction, heavy, which), heavy))
    chance, heavy = min(found, key=lambda pair: pair[0])
    return heavy if chance * (2.0 ** (count - 1) - 1) < criteria.false_alarms else None


def _amounts(moments: Moments) -> Array:
    """What each run shows along the payload's columns beside the model (runs, k), in directions of
    equal torque."""
    rows = moments.rows
    blocks, places = rows.made.blocks, list(rows.made.base.payload)
    run = rows.raw([np.full(len(block.at), k) for k, block in enumerate(blocks)])
    S, r = np.zeros((len(blocks), len(places), len(places))), np.zeros((len(blocks), len(places)))
    q = moments.fit(None).q
    for i in range(rows.n):
        columns = rows.white(i, [block.linear[:, i, places] for block in blocks])
        left = rows.white_y[i] - moments.white_X[i] @ q
        for k in range(len(blocks)):
            own = columns[run == k]
            S[k] += own.T @ own
            r[k] += own.T @ left[run == k]
    mean = S.mean(axis=0)
    size = np.sqrt(np.maximum(np.diag(mean), 1e-300))
    values, vectors = np.linalg.eigh(mean / np.outer(size, size))
    kept = values > SHARE**2
    turn = vectors[:, kept] / np.sqrt(values[kept]) / size[:, None]
    return np.array(
        [
            np.linalg.solve(turn.T @ one @ turn + SHARE * np.eye(kept.sum()), turn.T @ right)
            for one, right in zip(S, r, strict=True)
        ]
    )


def _cut(amount: Array) -> Mask:
    """The larger ones (runs,) where two halves spread least about their means."""
    order = np.argsort(amount)
    parts = [(amount[order[:k]], amount[order[k:]]) for k in range(1, len(order))]
    squares = [len(a) * a.var() + len(b) * b.var() for a, b in parts]
    heavy = np.zeros(len(amount), dtype=bool)
    heavy[order[1 + int(np.argmin(squares)) :]] = True
    return heavy


def _chance(amount: Array, heavy: Mask, which: NDArray[np.int64]) -> float:
    """p-value of the difference of two halves of the runs (runs,), `which` their trajectories.

    Where the cut passes through trajectories by all runs, or by passes of one trajectory alone if
    that tells more; else passes of a trajectory are one run.
    """
    named = which[:, None] == np.unique(which)
    alone = np.ones((len(amount), 1))
    if any(0 < heavy[own].sum() < own.sum() for own in named.T):
        return min(_f_test(amount, heavy, about) for about in (alone, named.astype(float)))
    means = np.array([amount[own].mean() for own in named.T])
    halves = np.array([heavy[own][0] for own in named.T])
    return _f_test(means, halves, np.ones((len(means), 1)))


def _f_test(amount: Array, heavy: Mask, about: Array) -> float:
    """p-value of another mean of some amounts, beside columns (runs, k)."""
    both = np.column_stack([about, heavy])
    free = len(amount) - np.linalg.matrix_rank(both)
    if free < 1:
        return 1.0
    before, after = (
        float(((amount - X @ np.linalg.lstsq(X, amount)[0]) ** 2).sum()) for X in (about, both)
    )
    return float(f_distribution.sf((before - after) * free / max(after, 1e-300), 1, free))


def _loaded(hypotheses: Hypotheses, heavy: Mask) -> Bench:
    """The base model fitted to runs of which some carry another payload; kept. The heavier ones
    carry it."""
    bench, found = hypotheses.bench, hypotheses.loaded
    key = tuple(bool(h) for h in heavy)
    if key not in found:
        made = _calibrated(bench.made, heavy)
        load = made.loads[-1]
        deltas = zip(load.known, made.fitted.loads[load.name], strict=True)
        sized = [(k.unit, delta / k.tolerance) for k, delta in deltas if k.tolerance]
        unit = next(unit for unit in MASSIVE if any(unit == own for own, _ in sized))
        if sum(size for own, size in sized if own == unit) < 0:
            made = _calibrated(bench.made, ~heavy)
        found[key] = bench.beside(made)
    return found[key]


def _calibrated(made: Calibrated, heavy: Mask) -> Calibrated:
    bit = max(block.run.loads for block in made.blocks).bit_length()
    blocks = [
        replace(b, run=replace(b.run, loads=b.run.loads | int(more) << bit))
        for b, more in zip(made.blocks, heavy, strict=True)
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

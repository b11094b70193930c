"""Whether runs fall into levels of payload, as far as each of them shows it by itself.

Runs are sorted by the amount of payload that each shows beside the model, and cut into levels.
Errors of a run go together, and trajectories differ in what the model lacks. So levels must stand
apart by more than the runs of one level do: an F test over passes about their trajectory's mean,
or, where no trajectory has several loads, over trajectories; for as many partitions as there are.
How far runs of one level may lie apart is hardly known of two or three of them. So one more run is
taken to lie apart by the smallest effect of interest: less is nothing that anybody would call one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from math import comb, factorial, log

import numpy as np
from numpy.typing import NDArray
from scipy.special import fdtrc

from flexhex.diagnosis.runs.noise import Noise, calmed, line, measured, whitening
from flexhex.diagnosis.selection.criteria import Criteria
from flexhex.diagnosis.selection.moments import Moments

Array = NDArray[np.float64]
Levels = NDArray[np.int64]
Mask = NDArray[np.bool_]
SHARE = 0.01
"""Weight of the mean run in the amount of payload of a run, which may excite too little of it."""
FAINT = 1e-4
"""Least curvature of a direction of the payload's columns, each of unit length: less is excited by
no run."""
MOST_LEVELS = 3
"""Levels that are told apart at once; what one of them still holds is asked in the next round."""


def levels_of(moments: Moments, criteria: Criteria) -> Levels | None:
    """How much each run carries, as the place of its level (runs,) in their order, if runs of one
    load surely fall into several levels: as few as will do, of the load whose runs show it best."""
    blocks = moments.rows.model.blocks
    if not moments.rows.model.base.payload:
        return None
    shown, loads = _shown(moments), np.array([block.run.loads for block in blocks])
    which = np.unique([block.run.trajectory for block in blocks], return_inverse=True)[1]
    for count in range(2, MOST_LEVELS + 1):
        cuts = list[tuple[float, Levels]]()
        for load in np.unique(loads):
            alike = loads == load
            if alike.sum() > count:
                least = criteria.smallest_effect**2 * shown.torque
                chance, levels = _levels(shown.of(alike), which[alike], count, least)
                all_levels = np.zeros(len(loads), dtype=np.int64)
                all_levels[alike] = levels
                cuts.append((chance + log(choices(levels, which[alike])), all_levels))
        chance, all_levels = min(cuts, key=lambda cut: cut[0], default=(0.0, loads))
        if chance < log(criteria.false_alarms):
            return all_levels
    return None


def choices(levels: Levels, which: Levels) -> int:
    """Ways to part runs of these trajectories into as many levels; trajectories that are not parted
    count as one."""
    parted = any(np.ptp(levels[which == one]) for one in which)
    return partitions(len(levels) if parted else len(np.unique(which)), len(np.unique(levels)))


def partitions(runs: int, parts: int) -> int:
    """Ways to part runs into so many non-empty sets: the number of Stirling; at least one."""
    signed: list[int] = [
        comb(parts, i) * i**runs * (-1 if (parts - i) % 2 else 1) for i in range(parts + 1)
    ]
    return max(sum(signed) // factorial(parts), 1)


@dataclass(frozen=True)
class Shown:
    """What each run shows along the payload's columns beside the model, in directions of equal
    torque: S (runs, k, k), r (runs, k) of its own least squares, S delta = r; torque: the mean
    square of an amount (k,) that would be all of a run's torque."""

    S: Array
    r: Array
    torque: float

    def of(self, runs: Mask) -> Shown:
        """Of some of the runs."""
        return Shown(self.S[runs], self.r[runs], self.torque)

    @property
    def amounts(self) -> Array:
        """Of each run (runs, k)."""
        return np.array(
            [Shown(S[None], r[None], 0.0).together for S, r in zip(self.S, self.r, strict=True)]
        )

    @property
    def together(self) -> Array:
        """Of all runs together (k,)."""
        firm = SHARE * len(self.r) * np.eye(self.r.shape[1])
        return np.asarray(np.linalg.solve(self.S.sum(axis=0) + firm, self.r.sum(axis=0)))

    def along(self, delta: Array) -> Array:
        """Of each run (runs,), as a share of an amount (k,): 0 of a run that excites nothing."""
        size = np.einsum("k,jkl,l->j", delta, self.S, delta) + SHARE * (delta @ delta)
        return np.asarray(self.r @ delta / np.maximum(size, np.finfo(float).tiny))


def _levels(shown: Shown, which: Levels, count: int, least: float) -> tuple[float, Levels]:
    """log p-value of the best cut of runs whose trajectories are `which`, and its levels (runs,);
    least: square of an amount (k,) by which runs of one level may lie apart.

    Along the direction that varies most, then by shares of what the ends of that cut differ in: of
    passes about their trajectory's mean, for trajectories differ in what the model lacks, or of all
    runs, as a trajectory may have one load alone: whichever sorts both better.
    """
    cuts = list[tuple[tuple[float, ...], Levels]]()
    for group in (which, np.zeros_like(which)):
        spread = _centred(shown.amounts, group)
        direction = np.linalg.svd(spread, full_matrices=False)[2][0]
        rough = _cut(spread @ direction, count)
        ends = [shown.of(rough == level).together for level in (0, count - 1)]
        share = shown.along(ends[1] - ends[0])
        levels = _cut(_centred(share, group), count)
        cuts.append((_chances(shown.amounts, levels, which, least), levels))
    chances, levels = min(cuts, key=lambda each: sum(each[0]))
    return chances[0], levels


def _centred(values: Array, group: Levels) -> Array:
    """Values (runs, ...) about the mean of their group."""
    return np.asarray(values - np.array([values[group == g].mean(axis=0) for g in group]))


def _shown(moments: Moments) -> Shown:
    """What each run shows.

    Passes that differ in load are no noise: the noise is that of what each run leaves beside
    columns of its own.
    """
    model, places = moments.rows.model, list(moments.rows.model.base.payload)
    left = _left(moments)
    columns = [block.linear.at(places) for block in model.blocks]
    plain = replace(Noise.even(model.base.n, 1.0), scale=model.torque_rms)
    turn, shown = _fitted(moments, columns, left, plain)
    each = zip(left, columns, shown.amounts, strict=True)
    own = [rest - C @ (turn @ one) for rest, C, one in each]
    listed = [replace(b, usable=good) for b, good in zip(model.blocks, model.kept, strict=True)]
    return _fitted(moments, columns, left, measured(listed, own))[1]


def _left(moments: Moments) -> list[Array]:
    """What the model leaves (m, n) [N m] of each block, zero in rows that do not count."""
    rows, q = moments.rows, moments.fit(None).q
    left = np.stack([rows.y[i] - moments.torque(i, q) for i in range(rows.n)], axis=1)
    kept = rows.model.kept
    parts = np.split(left, np.cumsum([good.sum() for good in kept])[:-1])
    residuals = [np.zeros((len(good), rows.n)) for good in kept]
    for full, good, part in zip(residuals, kept, parts, strict=True):
        full[good] = part
    return residuals


def _fitted(
    moments: Moments, columns: Sequence[Array], left: Sequence[Array], noise: Noise
) -> tuple[Array, Shown]:
    """Columns of each run (m, n, k) for what is left (m, n): directions (k, k') of equal torque,
    and what runs show in them."""
    n, k = columns[0].shape[1:]
    model = moments.rows.model
    S, r, torque = np.zeros((len(left), k, k)), np.zeros((len(left), k)), 0.0
    blocks = zip(model.kept, model.moving, strict=True)
    runs = zip(columns, left, model.torque, blocks, strict=True)
    for j, (C, rest, y, (kept, moving)) in enumerate(runs):
        for i in range(n):
            both = np.column_stack([C[:, i], rest[:, i], y[:, i]])
            white = whitening(noise.a[i], float(noise.scale[i]), kept) @ both
            white = calmed(white, noise.slow[i], line(moving[:, i]), moving[:, i])
            S[j] += white[:, :k].T @ white[:, :k]
            r[j] += white[:, :k].T @ white[:, k]
            torque += float(white[:, k + 1] @ white[:, k + 1]) / len(left)
    mean = S.mean(axis=0)
    size = np.sqrt(np.maximum(np.diag(mean), 1e-300))
    values, vectors = np.linalg.eigh(mean / np.outer(size, size))
    kept_ones = values > FAINT
    turn = vectors[:, kept_ones] / np.sqrt(values[kept_ones]) / size[:, None]
    return turn, Shown(turn.T @ S @ turn, r @ turn, torque)


def _cut(amount: Array, count: int) -> Levels:
    """Levels (runs,), ascending, where these spread least about their means."""
    order, best, edges = np.argsort(amount), np.inf, tuple[int, ...]()
    for cut in combinations(range(1, len(order)), count - 1):
        parts = np.split(amount[order], cut)
        squares = sum(len(part) * float(part.var()) for part in parts)
        if squares < best:
            best, edges = squares, cut
    levels = np.zeros(len(amount), dtype=np.int64)
    for edge in edges:
        levels[order[edge:]] += 1
    return levels


def _chances(amounts: Array, levels: Levels, which: Levels, least: float) -> tuple[float, ...]:
    """log p-values of the differences of levels between amounts (runs, k), `which` their
    trajectories: the first one is that which counts.

    Where the cut passes through trajectories: of passes about their trajectory's mean, and of all
    runs; else passes of a trajectory are one run.
    """
    named = which[:, None] == np.unique(which)
    if any(np.ptp(levels[own]) for own in named.T):
        abouts = (named.astype(float), np.ones((len(amounts), 1)))
        return tuple(_f_test(amounts, levels, about, least) for about in abouts)
    means = np.array([amounts[own].mean(axis=0) for own in named.T])
    each = np.array([levels[own][0] for own in named.T])
    return (_f_test(means, each, np.ones((len(means), 1)), least),)


def _f_test(amounts: Array, levels: Levels, about: Array, least: float) -> float:
    """log p-value of other means (k,) for every level, beside columns (runs, j).

    Of sums of squares over all k directions, as none was chosen beforehand; errors that go along
    few of them count as as many (Satterthwaite). least: square of one error more.
    """
    both = np.column_stack([about, levels[:, None] == np.unique(levels)[1:]])
    rank, plain = (int(np.linalg.matrix_rank(X)) for X in (both, about))
    free, more = len(amounts) - rank, rank - plain
    if free < 1 or more < 1:
        return 0.0
    before, after = (amounts - X @ np.linalg.lstsq(X, amounts)[0] for X in (about, both))
    errors = after.T @ after
    left = max(float(np.trace(errors)), 1e-300)
    ways = left**2 / max(float((errors**2).sum()), 1e-300)
    # one error more
    known = free + 1
    ratio = (float((before**2).sum()) - left) / more / ((left + least) / known)
    chance = float(fdtrc(more * ways, known * ways, ratio)) if ratio > 0 else 1.0
    return log(chance) if chance > 0 else -np.inf

"""From rounds of candidates to an answer: estimates with intervals, gaps, maps, locked runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from diagnosis.blocks import Block
from diagnosis.calibrate import Calibrated, about
from diagnosis.candidates import Bench
from diagnosis.noise import pairs
from diagnosis.regression import Columns, Regression
from diagnosis.rounds import Found, Scored, repeating

Array = NDArray[np.float64]
EXPLAINED = 0.5
"""Least share of what repeats on its axes that a named effect must explain, with the others."""
CERTAIN = 4.0
"""t above which a repeating residual is no chance."""
GAP = 0.002
"""Smallest repeating residual that counts as a gap, RMS relative to the torque's."""


@dataclass(frozen=True)
class Joint:
    """All effects that were found, fitted together with the base model.

    parts: each effect on each axis with its shape; beta: gains of the parts, one after the other,
    covariance of (gains, shape steps); q: coefficients of the base columns.
    """

    bench: Bench
    effects: tuple[Found, ...]
    beta: tuple[Array, ...]
    deviation: tuple[Array, ...]
    shape_deviation: tuple[dict[str, float], ...]
    q: Array

    @property
    def parts(self) -> list[Scored]:
        """Parts of all effects in order."""
        return [part for effect in self.effects for part in effect.parts]

    @cached_property
    def explained(self) -> list[Array]:
        """Torque of all effects (m, n) [N m] of each block."""
        return torque_of(self.bench, self.parts, self.beta)

    @cached_property
    def residual(self) -> list[Array]:
        """What is left (m, n) [N m] of each block."""
        made = self.bench.made
        left = made.residual(self.q)
        return [r - e for r, e in zip(left, self.explained, strict=True)]


def torque_of(bench: Bench, parts: Sequence[Scored], beta: Sequence[Array]) -> list[Array]:
    """Torque of effects with given gains (m, n) [N m] of each block of a bench."""
    total = [np.zeros((len(b.at), bench.n)) for b in bench.made.blocks]
    for part, gains in zip(parts, beta, strict=True):
        thin = bench.thin(part.id, part.axis or 0, part.shape)
        for k, values in enumerate(thin):
            torque = values @ gains
            if torque.ndim == 2:
                total[k] += torque
            else:
                total[k][:, part.axis or 0] += torque
    return total


def joint(bench: Bench, effects: Sequence[Found]) -> Joint:
    """Fit base model and effects together, shapes by one Gauss-Newton step."""
    regression = bench.made.regression
    parts = [part for effect in effects for part in effect.parts]
    if not parts:
        return Joint(bench, (), (), (), (), regression.q)
    parts = [_stepped(bench, regression, parts, k) for k in range(len(parts))]
    updated, at = [], 0
    for effect in effects:
        updated.append(replace(effect, parts=tuple(parts[at : at + len(effect.parts)])))
        at += len(effect.parts)
    columns, tangents, sizes = _stack(bench, regression, parts)
    gain = regression.gain(Columns(None, np.hstack([columns, tangents])))
    deviation = np.sqrt(np.maximum(np.diag(gain.covariance), 0.0))
    betas, deviations, at = [], [], 0
    plain = regression.gain(Columns(None, columns))
    for size in sizes:
        betas.append(plain.beta[at : at + size])
        deviations.append(deviation[at : at + size])
        at += size
    shaped = _shape_names(bench, parts)
    spread: list[dict[str, float]] = [{} for _ in parts]
    for (k, name), value in zip(shaped, deviation[at:], strict=True):
        spread[k][name] = float(value)
    full = regression.extended([Columns(None, columns)])
    q = full.q[: len(regression.prior)]
    lists = tuple(betas), tuple(deviations), tuple(spread)
    return Joint(bench, tuple(updated), *lists, q)


def _shape_names(bench: Bench, parts: Sequence[Scored]) -> list[tuple[int, str]]:
    found = []
    for k, part in enumerate(parts):
        item = bench.effects.get(part.id)
        if item is not None:
            found += [(k, s.name) for s in item.searched]
    return found


def _whole(regression: Regression, columns: Columns) -> Array:
    if columns.axis is None:
        return columns.values
    full = np.zeros((len(regression.y), columns.values.shape[1]))
    full[regression.layout.rows(columns.axis)] = columns.values
    return full


def _stack(
    bench: Bench, regression: Regression, parts: Sequence[Scored]
) -> tuple[Array, Array, list[int]]:
    """Columns of all parts (R, k), tangents of their shapes (R, s), columns of each part."""
    columns = [_whole(regression, part.columns) for part in parts]
    stacked = np.hstack(columns)
    beta = regression.gain(Columns(None, stacked)).beta
    sizes = [c.shape[1] for c in columns]
    starts = np.cumsum([0, *sizes])
    tangents = [
        _tangent(bench, regression, parts[k], name, beta[starts[k] : starts[k + 1]])
        for k, name in _shape_names(bench, parts)
    ]
    empty = np.zeros((len(stacked), 0))
    return stacked, np.hstack([empty, *tangents]), sizes


def _tangent(bench: Bench, regression: Regression, part: Scored, name: str, beta: Array) -> Array:
    shape = next(s for s in bench.effects[part.id].effect.shapes if s.name == name)
    step = 1e-3 * (abs(part.shape[name]) + 1e-3 * (max(shape.grid) - min(shape.grid)))
    sides = [
        bench.columns(part.id, part.axis or 0, {**part.shape, name: part.shape[name] + sign * step})
        for sign in (1.0, -1.0)
    ]
    change = Columns(sides[0].axis, (sides[0].values - sides[1].values) @ beta[:, None])
    return _whole(regression, change) / (2 * step)


def _stepped(bench: Bench, regression: Regression, parts: Sequence[Scored], k: int) -> Scored:
    """A part whose shape made one Gauss-Newton step, if that explains more."""
    part, item = parts[k], bench.effects.get(parts[k].id)
    if item is None or not item.searched:
        return part
    others = [p.columns for j, p in enumerate(parts) if j != k]
    beside = regression.extended(others) if others else regression
    fall, beta = beside.fall(part.columns)
    for s in item.searched:
        tangent = _tangent(bench, regression, part, s.name, beta)
        rows = regression.layout.rows(part.columns.axis)
        both = Columns(part.columns.axis, np.hstack([part.columns.values, tangent[rows]]))
        _, moved = beside.fall(both)
        value = float(np.clip(part.shape[s.name] + moved[-1], s.low, s.high))
        trial = bench.columns(part.id, part.axis or 0, {**part.shape, s.name: value})
        better, gains = beside.fall(trial)
        if better > fall:
            shape = {**part.shape, s.name: value}
            part, fall, beta = replace(part, shape=shape, columns=trial), better, gains
    return part


def lasting(bench: Bench, effects: Sequence[Found]) -> Joint:
    """The joint fit of those effects that hold: they explain enough of what repeats."""
    kept = list(effects)
    before = repeating(bench.made, bench.made.regression.residual)
    while True:
        made = joint(bench, kept)
        after = _after(made)
        weak = [
            k for k, effect in enumerate(made.effects) if _share(effect, before, after) < EXPLAINED
        ]
        if not weak:
            return made
        kept = [effect for k, effect in enumerate(made.effects) if k not in weak]


def _after(made: Joint) -> Array:
    regression = made.bench.made.regression
    columns = [part.columns for part in made.parts]
    fitted = regression.extended(columns) if columns else regression
    return repeating(made.bench.made, fitted.residual)


def _share(effect: Found, before: Array, after: Array) -> float:
    axes = list(effect.axes) or list(range(len(before)))
    return 1.0 - float(after[axes].sum()) / max(float(before[axes].sum()), 1e-300)


def shares(made: Joint) -> list[float]:
    """Share of what repeats on its axes that is explained, for each effect."""
    before = repeating(made.bench.made, made.bench.made.regression.residual)
    after = _after(made)
    return [_share(effect, before, after) for effect in made.effects]


def repeat_rms(blocks: Sequence[Block], residual: Sequence[Array]) -> tuple[Array, Array]:
    """RMS of what repeats (n,) [N m] and the t-value that it is no chance; NaN without passes."""
    n = residual[0].shape[1]
    products: list[list[float]] = [[] for _ in range(n)]
    for a, b in pairs(blocks):
        good = blocks[a].usable & blocks[b].usable
        second = np.floor(blocks[a].at).astype(int)
        for s in np.unique(second[good]):
            rows = good & (second == s)
            for i in range(n):
                products[i].append(float((residual[a][rows, i] * residual[b][rows, i]).mean()))
    if not products[0]:
        return np.full(n, np.nan), np.full(n, np.nan)
    table = np.array(products)
    mean = table.mean(axis=1)
    spread = table.std(axis=1, ddof=1) / np.sqrt(table.shape[1])
    return np.sqrt(np.maximum(mean, 0.0)), mean / np.maximum(spread, 1e-300)


def axis_rms(blocks: Sequence[Block], values: Sequence[Array]) -> Array:
    """RMS of each axis (n,) over the usable rows."""
    stacked = np.concatenate([v[b.usable] for v, b in zip(values, blocks, strict=True)])
    return np.asarray(np.sqrt((stacked**2).mean(axis=0)))


def elsewhere(made: Joint, blocks: Sequence[Block]) -> tuple[Calibrated, list[Array], list[Array]]:
    """The fit on other runs: their columns, residual without and with the effects."""
    ours = made.bench.made
    there = about(ours.base, blocks, ours.fitted, ours.noise)
    without = there.residual(ours.regression.q)
    bench = Bench(there, list(made.bench.effects.values()))
    torque = torque_of(bench, made.parts, made.beta)
    residual = there.residual(made.q)
    return there, without, [r - t for r, t in zip(residual, torque, strict=True)]

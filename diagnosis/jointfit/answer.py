"""Base model and effects fitted together: gains and shapes with intervals, what is left."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.hypotheses.candidates import Bench
from flexhex.diagnosis.jointfit.effects import Part, SelectedEffect
from flexhex.diagnosis.jointfit.stacked import blends, deviations_of, shape_names, stack
from flexhex.diagnosis.regression.calibrate import Calibrated
from flexhex.diagnosis.regression.regression import Columns, Regression
from flexhex.diagnosis.runs.blocks import Block
from flexhex.diagnosis.runs.noise import pairs, whiten

Array = NDArray[np.float64]
CORRELATED = 3.0
"""Rows that count as one, for what the noise model does not know."""


@dataclass(frozen=True)
class Joint:
    """All effects that were found, fitted together with the base model.

    parts: each effect on each axis with its shape; beta: gains of the parts, one after the other,
    deviation and shape_deviation: standard deviations of gains and shapes; bent: how far an error
    of the form as large as the effect moves each shape; sure: in how many deviations the gains of a
    part stand above zero together, further: its gains but the first; q: coefficients of the base
    columns; freed: inverse variances of base parameters that left their tolerances, by place.
    """

    bench: Bench
    effects: tuple[SelectedEffect, ...]
    beta: tuple[Array, ...]
    deviation: tuple[Array, ...]
    shape_deviation: tuple[dict[str, float], ...]
    bent: tuple[dict[str, float], ...]
    sure: tuple[float, ...]
    further: tuple[float, ...]
    q: Array
    freed: Mapping[int, float] = field(default_factory=dict)

    @property
    def parts(self) -> list[Part]:
        """Parts of all effects in order."""
        return [part for effect in self.effects for part in effect.parts]

    @property
    def geared(self) -> list[int]:
        """Axes whose effects ask what the rotor leaves of the torque."""
        effects = self.bench.effects
        return [p.axis for p in self.parts if p.axis is not None and effects[p.id].effect.geared]

    @cached_property
    def fitted(self) -> Regression:
        """All rows, base columns and effects beside each other."""
        fitted = self.bench.model.regression.loosened(self.freed)
        return fitted.extended([part.columns for part in self.parts]) if self.parts else fitted

    @cached_property
    def covariance(self) -> Array:
        """Of q (nb, nb)."""
        fitted = self.fitted
        level = max(1.0, float((fitted.residual**2).mean())) * CORRELATED
        count = len(self.q)
        wider = np.sqrt(np.maximum(fitted.doubt[:count], level))
        return np.asarray(fitted.covariance[:count, :count] * np.outer(wider, wider))

    @cached_property
    def explained(self) -> list[Array]:
        """Torque of all effects (m, n) [N m] of each block."""
        return torque_of(self.bench, self.parts, self.beta)

    @cached_property
    def residual(self) -> list[Array]:
        """What is left (m, n) [N m] of each block."""
        model = self.bench.model
        left = model.residual(self.q)
        return [r - e for r, e in zip(left, self.explained, strict=True)]


def torque_of(bench: Bench, parts: Sequence[Part], beta: Sequence[Array]) -> list[Array]:
    """Torque of effects with given gains (m, n) [N m] of each block of a bench."""
    total = [np.zeros((len(b.at), bench.n)) for b in bench.model.blocks]
    for part, gains in zip(parts, beta, strict=True):
        thin = bench.thin(part.id, part.axis or 0, part.shape)
        for k, values in enumerate(thin):
            torque = values @ gains
            if torque.ndim == 2:
                total[k] += torque
            else:
                total[k][:, part.axis or 0] += torque
    return total


def steady(model: Calibrated, drift: Joint) -> Calibrated:
    """Runs with a drift from run to run taken off their torque."""
    bench = Bench(model, list(drift.bench.effects.values()), across=True)
    torque = torque_of(bench, drift.parts, drift.beta)
    return replace(model, y=tuple(y - t for y, t in zip(model.y, torque, strict=True)))


def joint(
    bench: Bench,
    effects: Sequence[SelectedEffect],
    freed: Mapping[int, float] = MappingProxyType({}),
) -> Joint:
    """Fit base model and effects together, shapes by one Gauss-Newton step."""
    regression = bench.model.regression.loosened(freed)
    parts = [part for effect in effects for part in effect.parts]
    count = len(regression.prior)
    if not parts:
        return Joint(bench, (), (), (), (), (), (), (), regression.q, freed)
    if blended := blends(bench, regression, parts):
        regression = regression.extended(blended)
    shaped = shape_names(bench, parts)
    if shaped:
        parts = _stepped(bench, regression, parts, shaped)
    columns, tangents = stack(bench, regression, parts)
    deviations = deviations_of(bench, regression, parts, columns, tangents)
    edges = np.cumsum([part.columns.values.shape[1] for part in parts])
    _, beta = regression.fall(Columns(None, columns))
    q = regression.extended([Columns(None, columns)]).q[:count]
    places = np.split(np.arange(edges[-1]), edges[:-1])
    gains, deviation = (tuple(v[k] for k in places) for v in (beta, deviations.gains))
    blocks = [deviations.covariance[np.ix_(k, k)] for k in places]
    sure = tuple(map(_sure, gains, deviation, blocks))
    further = tuple(
        _sure(g[1:], d[1:], block[1:, 1:])
        for g, d, block in zip(gains, deviation, blocks, strict=True)
    )
    shapes, bent = tuple(deviations.shapes), tuple(deviations.bent)
    regrouped = _regrouped(effects, parts)
    return Joint(bench, regrouped, gains, deviation, shapes, bent, sure, further, q, freed)


def _sure(beta: Array, deviation: Array, covariance: Array) -> float:
    """In how many deviations gains (k,) stand above zero together; those held there do not count,
    nor do those that the runs do not determine."""
    free = (deviation > 0.0) & np.isfinite(deviation)
    inverse = np.linalg.pinv(covariance[np.ix_(free, free)], hermitian=True)
    return math.sqrt(max(float(beta[free] @ inverse @ beta[free]), 0.0))


def again(fit: Joint, bench: Bench) -> Joint:
    """The same effects fitted beside another base model, shapes from where they were."""
    parts = [part.moved(bench, part.shape) for part in fit.parts]
    return joint(bench, _regrouped(fit.effects, parts), fit.freed)


def _regrouped(
    effects: Sequence[SelectedEffect], parts: Sequence[Part]
) -> tuple[SelectedEffect, ...]:
    """The effects with their parts renewed."""
    updated, at = [], 0
    for effect in effects:
        updated.append(replace(effect, parts=tuple(parts[at : at + len(effect.parts)])))
        at += len(effect.parts)
    return tuple(updated)


def _stepped(
    bench: Bench,
    regression: Regression,
    parts: Sequence[Part],
    shaped: Sequence[tuple[int, str]],
) -> list[Part]:
    """All shapes after one Gauss-Newton step together, if that explains more."""
    columns, tangents = stack(bench, regression, parts)
    before, _ = regression.fall(Columns(None, columns))
    _, step = regression.fall(Columns(None, np.hstack([columns, tangents])))
    shapes = [dict(part.shape) for part in parts]
    for (k, name), move in zip(shaped, step[columns.shape[1] :], strict=True):
        shape = bench.scales.ranges(parts[k].id, parts[k].axis or 0)[name]
        shapes[k][name] = float(np.clip(shapes[k][name] + move, shape.low, shape.high))
    moved = [part.moved(bench, shape) for part, shape in zip(parts, shapes, strict=True)]
    after, _ = regression.fall(
        Columns(None, np.hstack([regression.spread(part.columns) for part in moved]))
    )
    return moved if after > before else list(parts)


def shares(fit: Joint) -> list[float]:
    """Share of what repeats on its axes beside the other effects that each effect explains.

    By how much parameters need leave their tolerances no more counts as explained; by how much
    they still do says nothing of these axes.
    """
    there, regression = fit.bench.model, fit.bench.model.regression.loosened(fit.freed)

    def left(effects: Sequence[SelectedEffect]) -> tuple[Array, float]:
        columns = [part.columns for effect in effects for part in effect.parts]
        fitted = regression.extended(columns) if columns else regression
        return repeating(there, fitted.residual), fitted.strain

    after, strained = left(fit.effects)
    fractions = []
    for effect in fit.effects:
        axes = list(effect.axes) or list(range(there.base.n))
        before, strain = left([other for other in fit.effects if other is not effect])
        rest = float(after[axes].sum())
        explained = float(before[axes].sum()) - rest + max(strain - strained, 0.0)
        fractions.append(explained / max(explained + rest, 1e-300))
    return fractions


def repeating(model: Calibrated, residual: Array) -> Array:
    """Sum of squares of what repeats of a whitened residual (R,), for each axis (n,).

    Without repeats the sum of all squares, an upper bound.
    """
    products = (model.layout.across(residual) if model.between else residual) * residual
    total = [products[model.layout.rows(i)].sum() for i in range(model.base.n)]
    return np.asarray(np.maximum(np.array(total), 0.0))


def repeat_rms(model: Calibrated, residual: Sequence[Array]) -> tuple[Array, Array]:
    """RMS of what repeats (n,) [N m] and how certain that is; NaN without passes.

    certain (n,): sum of products of whitened passes, in deviations of what noise would give.
    """
    n, total, certain, rows = model.base.n, np.zeros(model.base.n), np.zeros(model.base.n), 0
    for a, b in pairs(model.blocks):
        good = model.kept[a] & model.kept[b]
        rows += int(good.sum())
        total += (residual[a][good] * residual[b][good]).sum(axis=0)
        for i in range(n):
            noise = model.noise.a[i], float(model.noise.scale[i])
            white = [whiten(residual[k][:, i : i + 1], *noise)[good, 0] for k in (a, b)]
            certain[i] += float(white[0] @ white[1])
    if not rows:
        return np.full(n, np.nan), np.full(n, np.nan)
    return np.sqrt(np.maximum(total / rows, 0.0)), certain / np.sqrt(rows)


def axis_rms(blocks: Sequence[Block], values: Sequence[Array]) -> Array:
    """RMS of each axis (n,) over the usable rows."""
    stacked = np.concatenate([v[b.usable] for v, b in zip(values, blocks, strict=True)])
    return np.asarray(np.sqrt((stacked**2).mean(axis=0)))

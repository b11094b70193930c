"""Base model and effects fitted together: gains and shapes with intervals, what is left."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.hypotheses.candidates import Bench
from flexhex.diagnosis.jointfit.effects import Part, SelectedEffect
from flexhex.diagnosis.jointfit.leftover import repeating
from flexhex.diagnosis.jointfit.stacked import (
    Deviations,
    blends,
    deviations_of,
    shape_names,
    stack,
)
from flexhex.diagnosis.jointfit.steps import stepped
from flexhex.diagnosis.regression.calibrate import Calibrated
from flexhex.diagnosis.regression.regression import Columns, Regression

Array = NDArray[np.float64]
CORRELATED = 3.0
"""Rows that count as one, for what the noise model does not know."""


@dataclass(frozen=True)
class Joint:
    """All effects that were found, fitted together with the base model.

    parts: each effect on each axis with its shape; beta: gains of the parts, one after the other;
    q: coefficients of the base columns; freed: inverse variances of base parameters that left their
    tolerances, by place; blended: columns that bend the gains, see `blends`. How sure gains and
    shapes are is computed when asked for, as most fits only say what is left.
    """

    bench: Bench
    effects: tuple[SelectedEffect, ...]
    beta: tuple[Array, ...]
    q: Array
    freed: Mapping[int, float] = field(default_factory=dict)
    blended: tuple[Columns, ...] = ()

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
    def deviations(self) -> Deviations:
        """How sure gains and shapes are."""
        regression = _freed(self.bench, self.freed, self.blended)
        columns, tangents = stack(self.bench, regression, self.parts)
        return deviations_of(self.bench, regression, self.parts, columns, tangents)

    @property
    def deviation(self) -> tuple[Array, ...]:
        """Standard deviations of the gains of each part."""
        return tuple(self.deviations.gains[k] for k in self._places)

    @property
    def turned(self) -> tuple[Array, ...]:
        """How far errors of their forms as large as the effects move the gains of each part with
        the shapes."""
        return tuple(self.deviations.turned[k] for k in self._places)

    @cached_property
    def sure(self) -> tuple[float, ...]:
        """In how many deviations the gains of each part stand above zero together."""
        return tuple(map(_sure, self.beta, self.deviation, self._covariances))

    @cached_property
    def further(self) -> tuple[float, ...]:
        """The same of its gains but the first."""
        each = zip(self.beta, self.deviation, self._covariances, strict=True)
        return tuple(_sure(g[1:], d[1:], block[1:, 1:]) for g, d, block in each)

    @property
    def _places(self) -> list[slice]:
        """Where the gains of each part stand in those of all."""
        edges = np.cumsum([0, *map(len, self.beta)])
        return [slice(a, b) for a, b in pairwise(edges)]

    @property
    def _covariances(self) -> list[Array]:
        return [self.deviations.covariance[k, k] for k in self._places]

    @property
    def spread(self) -> Array:
        """Covariance of q (nb, nb) for noise of unit variance."""
        return self._covariance[0]

    @property
    def covariance(self) -> Array:
        """Of q (nb, nb)."""
        return self._covariance[1]

    @cached_property
    def _covariance(self) -> tuple[Array, Array]:
        """Both, without the rows that they come from: base columns and effects side by side."""
        fitted = _freed(self.bench, self.freed, [part.columns for part in self.parts])
        level = max(1.0, float((fitted.residual**2).mean())) * CORRELATED
        count = len(self.q)
        wider = np.sqrt(np.maximum(fitted.doubt[:count], level))
        spread = fitted.covariance[:count, :count].copy()
        return spread, np.asarray(spread * np.outer(wider, wider))

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


def drifting(model: Calibrated, drift: Joint) -> list[Array]:
    """Torque (m, n) [N m] of each block that a drift from run to run explains."""
    bench = Bench(model, list(drift.bench.effects.values()), across=True)
    return list(torque_of(bench, drift.parts, drift.beta))


def joint(
    bench: Bench,
    effects: Sequence[SelectedEffect],
    freed: Mapping[int, float] = MappingProxyType({}),
) -> Joint:
    """Fit base model and effects together, shapes by one Gauss-Newton step."""
    regression = _freed(bench, freed)
    parts = [part for effect in effects for part in effect.parts]
    count = len(regression.prior)
    if not parts:
        return Joint(bench, (), (), regression.q, freed)
    blended = tuple(blends(bench, regression, parts))
    regression = regression.extended(blended)
    shaped = shape_names(bench, parts)
    if shaped:
        parts = stepped(bench, regression, parts, shaped)
    columns = Columns(None, np.hstack([regression.spread(part.columns) for part in parts]))
    beta, q = regression.together(columns)
    edges = np.cumsum([part.columns.values.shape[1] for part in parts])
    gains = tuple(np.split(beta, edges[:-1]))
    return Joint(bench, _regrouped(effects, parts), gains, q[:count], freed, blended)


def _freed(bench: Bench, freed: Mapping[int, float], blended: Sequence[Columns] = ()) -> Regression:
    """The rows of a bench with loosened parameters and further columns."""
    return bench.model.regression.loosened(freed).extended(blended)


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


def shares(fit: Joint) -> list[float]:
    """Share of what repeats on its axes beside the other effects that each effect explains.

    By how much parameters need leave their tolerances no more counts as explained; by how much
    they still do says nothing of these axes.
    """
    there, regression = fit.bench.model, fit.bench.model.regression.loosened(fit.freed)

    def left(effects: Sequence[SelectedEffect]) -> tuple[Array, float]:
        columns = [part.columns for effect in effects for part in effect.parts]
        fitted = regression.extended(columns)
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

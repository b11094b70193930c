"""Friction and found effects at states that are chosen, for a simulation.

A torque that rises steeply with the rate, as dry friction at rest does, is given with a slope: of
the line from where it is to where it vanishes. An implicit step that takes this slope for the
derivative comes nearer to the solution each time, and never swings about zero (a majorant of the
friction's potential).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Protocol

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.estimation.estimate import Estimated
from flexhex.diagnosis.estimation.extras import Extra
from flexhex.diagnosis.estimation.friction import GROUP, Form
from flexhex.diagnosis.estimation.motion import dahl_states
from flexhex.diagnosis.hypotheses.compiled import N_SIGNAL, Compiled, compiled, signals
from flexhex.diagnosis.hypotheses.signals import let_through
from flexhex.diagnosis.hypotheses.turning import followed, halved, states_of
from flexhex.diagnosis.runs.run import Run
from flexhex.numeric.rows import RowFunction, alike, native

Array = NDArray[np.float64]
TINY = 1e-9
"""Rates and ways [rad/s, rad] below which a quotient is that of these."""


@dataclass(frozen=True)
class Step:
    """From an instant to one `dt` [s] later of an axis: before, rate (windows,) there; then, fast
    (windows,) here; tau (windows,), the reported torque in between; time (windows,) [s] here, since
    the start of the run."""

    before: Array
    rate: Array
    then: Array
    fast: Array
    tau: Array
    time: Array
    dt: float


class Part(Protocol):
    """A torque of an axis (from 0) beside the base model."""

    @property
    def axis(self) -> int: ...

    def along(self, run: Run, window: float, delay: float) -> Array:
        """States (samples, k) along a measured run, as the fit has them; window: its smoothing,
        delay [s] of the torques."""
        ...

    def follow(self, step: Step, state: Array) -> Array:
        """States after a step."""
        ...

    def torque(self, step: Step, state: Array) -> tuple[Array, Array]:
        """Torque (windows,) at the end of a step, and its slope over the rate; state: before it."""
        ...


@dataclass(frozen=True)
class Friction:
    """Dry F_c in its form, viscous d, offset o of an axis (from 0)."""

    axis: int
    dry: float
    viscous: float
    offset: float
    form: Form

    def along(self, run: Run, window: float, delay: float) -> Array:
        """Presliding z of Dahl."""
        theta = run.motion.steady[:, [self.axis]]
        if self.form.kind == "way":
            return dahl_states(theta, self.form.size)
        return np.zeros_like(theta)

    def follow(self, step: Step, state: Array) -> Array:
        """z' = (thetad - |thetad| z) / s_0, exactly for a step of one sign."""
        way, left = self._way(step)
        return left[:, None] * state + (np.sign(way) * (1 - left))[:, None]

    def torque(self, step: Step, state: Array) -> tuple[Array, Array]:
        """See `flexhex.diagnosis.estimation.friction`."""
        plain = self.viscous * step.fast + self.offset
        if self.form.kind == "way":
            z, (way, left) = self.follow(step, state)[:, 0], self._way(step)
            # (z - z before) / way, as it is for a small one, too
            share = np.where(np.abs(way) < TINY * self.form.size, 1 / self.form.size,
                             (1 - left) / np.maximum(np.abs(way), 1e-300))  # fmt: skip
            slope = share * (1 - np.sign(way) * state[:, 0]) * step.dt
            return plain + self.dry * z, self.viscous + self.dry * np.maximum(slope, 0.0)
        by = (1 + self.form.lead / step.dt) / self.form.size
        x = step.fast * by - step.rate * self.form.lead / step.dt / self.form.size
        s = np.tanh(x)
        slope = by * np.where(np.abs(x) < TINY, 1.0, s / np.where(x == 0, 1.0, x))
        return plain + self.dry * s, self.viscous + self.dry * slope

    def _way(self, step: Step) -> tuple[Array, Array]:
        way = step.then - step.before
        return way, np.exp(-np.abs(way) / self.form.size)


@dataclass(frozen=True)
class Added:
    """An effect of the library on an axis (from 0) that goes with its angle, rate, reported torque
    and time, and with what it remembers of them."""

    axis: int
    item: Compiled
    gains: Array
    shape: Array
    after: RowFunction | None

    def along(self, run: Run, window: float, delay: float) -> Array:
        """States of the effect."""
        motion = run.motion
        if self.after is None:
            return np.zeros((len(motion.theta), 1))
        theta, thetad = motion.theta[:, self.axis], motion.thetad[:, self.axis]
        known, clock = run.tau.valid, run.tau.t0 + run.tau.ts * np.arange(len(run.tau.values))
        tau = np.interp(motion.time + delay, clock[known], run.tau.values[known, self.axis])
        plain = _signals(theta, thetad, tau, motion.time - motion.t0)
        inputs = followed(self.item, plain, motion, self.axis, window)
        names = [one.name for one in self.item.effect.shapes]
        shape = dict(zip(names, self.shape.tolist(), strict=False))
        both = [(inputs, halved(self.item, inputs))]
        return states_of(self.item, shape, self.axis, [run], both, False, window)[0]

    def follow(self, step: Step, state: Array) -> Array:
        """States after a step."""
        if self.after is None:
            return state
        before = _signals(step.before, step.rate, step.tau, step.time - step.dt)
        now = _signals(step.then, step.fast, step.tau, step.time)
        given = alike(np.append(self.shape, step.dt), len(state))
        return self.after(before, now, state, given)[0]

    def torque(self, step: Step, state: Array) -> tuple[Array, Array]:
        """Torque, and its slope to that of a step at which the axis stands still."""
        here = self._at(step, state)
        small = np.where(np.abs(step.fast) < TINY, TINY, step.fast)
        moved = replace(step, then=step.before + step.dt * small, fast=small)
        rest = replace(step, then=step.before, fast=np.zeros_like(small))
        slope = (self._at(moved, state) - self._at(rest, state)) / small
        return here, np.maximum(slope, 0.0)

    def _at(self, step: Step, state: Array) -> Array:
        now = _signals(step.then, step.fast, step.tau, step.time)
        columns = self.item.columns(now, self.follow(step, state), alike(self.shape, len(now)))[0]
        return np.asarray(columns @ self.gains)


def _signals(theta: Array, thetad: Array, tau: Array, time: Array) -> Array:
    none = np.zeros_like(theta)
    return np.stack([theta, thetad, none, tau, none, time], axis=1)


def parts_of(estimated: Estimated) -> tuple[list[Part], list[str]]:
    """Friction and effects of a fit, but for those that `through_drives` has, and what of it a
    simulation leaves out."""
    values = dict(zip([k.name for k in estimated.known], estimated.values, strict=True))
    rubs = {k.name: float(values[k.name]) for k in estimated.known if k.group == GROUP}
    parts = list[Part]()
    for i, form in enumerate(estimated.forms):
        dry, viscous, offset = (rubs.get(f"{name}[{i + 1}]", 0.0) for name in ("F_c", "d", "o"))
        if dry or viscous or offset:
            parts.append(Friction(i, dry, viscous, offset, form))
    effects = {one.effect.id: one.effect for one in estimated.extras.listed}
    items = compiled(estimated.model.base.n, effects) if effects else []
    driven = {item.effect.id: item for item in items if item.driven}
    out = []
    for one in estimated.extras.listed:
        if one.effect.line or one.effect.loses:
            continue
        if one.effect.id in driven:
            parts.append(_added(one, driven[one.effect.id], values))
        else:
            out.append(f"{one.effect.id} of axis {one.axis + 1}")
    if estimated.model.base.geometry is not None:
        out.append("errors of the geometry")
    return parts, out


def file_parts(estimated: Estimated) -> list[Part]:
    """Effects that the file has, with its values."""
    n, parts = estimated.model.base.n, list[Part]()
    for use in estimated.extras.file:
        (item,) = compiled(n, {use.id: use.effect})
        for axis, gains in zip(use.axes, np.transpose(use.gains).tolist(), strict=True):
            one = Extra(use.effect, axis - 1, use.shape, 1, tuple(gains))
            names = [one.parameter(gain.name) for gain in use.effect.gains]
            if item.driven and not use.effect.loses:
                parts.append(_added(one, item, dict(zip(names, gains, strict=True))))
    return parts


def through_drives(estimated: Estimated, torque: Array, ts: float) -> Array:
    """Torques (samples, n) of a log every ts [s] behind drives that lag, are late or lose some."""
    values = dict(zip([k.name for k in estimated.known], estimated.values, strict=True))
    behind = torque.copy()
    for one in estimated.extras.listed:
        gain, own = values.get(one.parameter(one.effect.gains[0].name), 0.0), [one.axis]
        if one.effect.loses:
            behind[:, own] *= 1.0 - gain
        if one.effect.line and gain > 0:
            behind[:, own] = let_through(behind[:, own], one.effect.line, gain, ts)
    return behind


def _added(one: Extra, item: Compiled, values: Mapping[str, float]) -> Added:
    effect = one.effect
    gains = np.array([values[one.parameter(gain.name)] for gain in effect.gains])
    shape = [values.get(one.parameter(s.name), float(one.shape[s.name])) for s in effect.shapes]
    after = None
    if effect.states:
        before, now = (ca.SX.sym(name, N_SIGNAL) for name in ("before", "now"))
        state, given = ca.SX.sym("state", len(effect.states)), ca.SX.sym("g", len(shape) + 1)
        own = {s.name: given[k] for k, s in enumerate(effect.shapes)}
        a, b = (signals(0, u) for u in (before, now))
        then = ca.densify(effect.advance(a, b, state, own, given[len(shape)]))
        name, inputs = f"native_after_{effect.id}", [before, now, state, given]
        (after,) = native([ca.Function(name, inputs, [ca.cse(then)])])
    return Added(one.axis, item, gains, np.array(shape or [0.0]), after)

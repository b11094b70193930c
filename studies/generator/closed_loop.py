"""Runs of cases by a full closed loop: the mechanism integrated, with the effects inside.

Own forward dynamics (mass matrix from the inverse dynamics of unit accelerations), an own
adaptive Runge-Kutta of order 3(2) (Bogacki and Shampine), digital PID at 2 kHz with the nominal
model's torque as feedforward. Runs of several cases are integrated side by side at one step,
that of the run which needs the shortest; arrays are (6, runs).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from studies.generator.base import Base, chi
from studies.generator.draw import Case
from studies.generator.drives import Drive, Encoder, Motor
from studies.generator.inverse import CURRENT_LOOP, Scaled, clocks, disturbance, references, scale
from studies.generator.masses import Linear
from studies.generator.mechanism import Mechanism
from studies.generator.torques import Torque
from studies.generator.trajectories import RATE, WARM, Controller, Motion
from tests.oracles.calculus import Array
from tests.oracles.machine import Actuator

TOLERANCE = 1e-5
"""Estimated error of a step [rad/s]; a thousandth of it in rad, ten times it in other states."""


@dataclass(frozen=True)
class Prepared:
    """A case before it runs: base, nominal torque along the reference, effects, noise."""

    case: Case
    base: Base
    ref: Motion
    ahead: Array
    scaled: tuple[Scaled, ...]
    clock: Array
    w: Array


def prepare(case: Case) -> Prepared:
    """Everything known before the loop closes; ValueError for effects that it does not know."""
    base, clock, ref = Base(case.truth), clocks(case), references(case)
    q, v, a = (np.repeat(x, case.passes, axis=1) for x in ref)
    m = np.repeat(base.torque(*ref), case.passes, axis=1)
    scaled = tuple(scale(h, base, clock, (q, v, a), m) for h in case.hidden)
    for s in scaled:
        if not s.effect.closed:
            raise ValueError(f"{s.hidden.id}: not in the closed loop, only by inverse dynamics")
    ahead = np.repeat(Base(case.nominal).torque(*ref), case.passes, axis=1)
    w = disturbance(case.noise, *clock.shape)
    return Prepared(case, base, (q, v, a), ahead, scaled, clock, w)


class Loop:
    """All runs of all cases side by side; `part` are the runs of each case."""

    def __init__(self, prepared: Sequence[Prepared]) -> None:
        self.prepared = prepared
        ends = np.cumsum([0, *(p.clock.shape[0] for p in prepared)])
        self.part = [slice(int(a), int(b)) for a, b in pairwise(ends)]
        runs = int(ends[-1])
        self.mechanism = Mechanism(prepared[0].case.nominal)
        every = [p for p in prepared for _ in range(p.clock.shape[0])]
        fields = zip(*(vars(p.base.p).values() for p in every), strict=True)
        self.p = Linear(*(np.stack(values, axis=-1)[:, None] for values in fields))
        acts = [p.case.truth.actuator for p in every]
        terms = {n: np.stack([getattr(x, n) for x in acts], axis=-1) for n in "okdcab"}
        self.actuator = Actuator(**terms, sigma=0.0, omega=acts[0].omega)
        self.sigma = np.array([x.sigma for x in acts])
        first = np.concatenate([p.ref[0][..., 0] for p in prepared], axis=-1)
        self.near = self.mechanism.close(first)
        listed = [(r, s) for r, p in zip(self.part, prepared, strict=True) for s in p.scaled]
        self.torques = [x for x in listed if isinstance(x[1].effect, Torque)]
        self.motors = [x for x in listed if isinstance(x[1].effect, Motor)]
        self.encoders = [x for x in listed if isinstance(x[1].effect, Encoder)]
        self.states = [s.effect.states for _, s in self.torques]  # type: ignore[union-attr]
        self.lag, self.bound = np.full((6, runs), CURRENT_LOOP), np.zeros((6, runs))
        for part, s in listed:
            if isinstance(s.effect, Drive):
                where = self.bound if s.effect.kind == "limit" else self.lag
                where[:, part] += s.gain[:, None]

    def start(self, q: Array, v: Array) -> Array:
        """State (3 + all effect states, 6, runs): q, v, Dahl z, then the effects'."""
        return np.stack([q, v, *[0 * q] * (1 + sum(self.states))])

    def rates(self, t: Array, y: Array, i: Array, w: Array) -> Array:
        """Derivative of the state where the drives give i and the disturbance is w [N m]."""
        q, v, z = y[:3]
        force, inertia = chi(self.actuator, q, v, z), np.zeros(q.shape)
        m, at = i.copy(), 3
        for part, s in self.motors:
            assert isinstance(s.effect, Motor)
            m[:, part] = s.effect.real(s.gain, m[:, part], t[part], q[:, part])
        for (part, s), n in zip(self.torques, self.states, strict=True):
            assert isinstance(s.effect, Torque)
            own, gain = y[at : at + n, :, part], s.gain[:, None]
            force[:, part] += gain * s.effect.force(t[part], q[:, part], v[:, part], own)
            inertia[:, part] += gain * s.effect.inertia(q[:, part])
            at += n
        a = self._accelerations(q, v, m - w - force, inertia)
        rates, at = [v, a, v / self.sigma * (1 - np.sign(v) * z)], 3
        for (part, s), n in zip(self.torques, self.states, strict=True):
            assert isinstance(s.effect, Torque)
            if n:
                rate = np.zeros((n, *q.shape))
                own = y[at : at + n, :, part]
                rate[..., part] = s.effect.rate(t[part], q[:, part], v[:, part], a[:, part], own)
                rates += list(rate)
            at += n
        return np.stack(rates)

    def _accelerations(self, q: Array, v: Array, m: Array, inertia: Array) -> Array:
        """a of M(q) a + h(q, v) = m; rows: motion at rest, six unit accelerations, the rates."""
        pose = self.mechanism.pose(q[:, None], tuple(x[:, None] for x in self.near))  # type: ignore[arg-type]
        self.near = pose.x_E[:, 0], pose.lam_E[:, 0]
        rates, unit = np.zeros((2, 6, 8, q.shape[1]))
        rates[:, 7] = v
        unit[range(6), range(1, 7)] = 1.0
        tau = self.mechanism.torque(pose, rates, unit, self.p)
        M = (tau[:, 1:7] - tau[:, :1]).transpose(2, 0, 1)
        M[:, range(6), range(6)] += inertia.T
        return np.asarray(np.linalg.solve(M, (m - tau[:, 7]).T[..., None])[..., 0].T)


def integrate(loop: Loop, seconds: float) -> tuple[dict[str, Array], int]:
    """Signals (6, runs, samples) at the ticks, `seconds` after WARM; and the number of steps."""
    cases = loop.prepared
    ref, rate = (np.concatenate([p.ref[n] for p in cases], axis=1) for n in range(2))
    ahead = np.concatenate([p.ahead for p in cases], axis=1)
    w = np.concatenate([p.w for p in cases], axis=1)
    clock = np.concatenate([p.clock for p in cases])
    ticks, Ts = round((seconds + WARM) * RATE), 1 / RATE
    y, control = loop.start(ref[..., 0], rate[..., 0]), _Digital(Controller().gains, Ts)
    command = i = ahead[..., 0].copy()
    names = ("q", "v", "reading", "i", "tau")
    log = {name: np.zeros((6, ref.shape[1], ticks)) for name in names}
    steps, h = 0, Ts
    for k in range(ticks):
        reading = _read(loop, y[0], y[1])
        for name, value in zip(names, (y[0], y[1], reading, i, command), strict=True):
            log[name][..., k] = value
        new = ahead[..., min(k + 1, ticks - 1)] + ahead[..., min(k + 2, ticks - 1)]
        acts = command  # what is computed at a tick acts from the next one
        bound = np.where(loop.bound > 0, loop.bound, 1.0)
        target = np.where(loop.bound > 0, np.tanh(bound * acts) / bound, acts)
        start, done, t = i, 0.0, clock[:, k]

        def at(s: float, target: Array = target, start: Array = start) -> Array:
            return np.asarray(target + (start - target) * np.exp(-s / loop.lag))

        slope = loop.rates(t, y, i, w[..., k])
        while done < Ts * (1 - 1e-9):
            tried = min(h, Ts - done)
            new_y, new_slope, error = _step(loop, t, (y, slope), at, w[..., k], done, tried)
            if error <= 1:
                y, slope, done, steps = new_y, new_slope, done + tried, steps + 1
            if error > 1 or tried == h:  # not what was cut off at the tick
                h = min(Ts, tried * min(4.0, max(0.2, 0.9 / max(error, 1e-9) ** (1 / 3))))
        i = at(Ts)
        command = new / 2 + control(ref[..., k] - np.round(reading / 1e-8) * 1e-8)
    return log, steps


def _step(
    loop: Loop,
    t: Array,
    now: tuple[Array, Array],
    i: Callable[[float], Array],
    w: Array,
    s: float,
    h: float,
) -> tuple[Array, Array, float]:
    """One trial of Bogacki and Shampine's pair from s [s] after the tick, where state and slope
    are `now`: state and slope at its end, error over tolerance."""
    y, k1 = now
    k2 = loop.rates(t + s + h / 2, y + h / 2 * k1, i(s + h / 2), w)
    k3 = loop.rates(t + s + 3 / 4 * h, y + 3 / 4 * h * k2, i(s + 3 / 4 * h), w)
    new = y + h * (2 / 9 * k1 + 1 / 3 * k2 + 4 / 9 * k3)
    k4 = loop.rates(t + s + h, new, i(s + h), w)
    error = np.abs(h * (-5 / 72 * k1 + 1 / 12 * k2 + 1 / 9 * k3 - 1 / 8 * k4))
    scale = np.full(y.shape, TOLERANCE)
    scale[0], scale[2:] = TOLERANCE / 1000, 10 * TOLERANCE
    return new, k4, float(np.max(error / scale))


def _read(loop: Loop, q: Array, v: Array) -> Array:
    """Angles as the encoders show them."""
    angles = q.copy()
    for part, s in loop.encoders:
        assert isinstance(s.effect, Encoder)
        angles[:, part] = s.effect.reading(s.gain, q[:, part], v[:, part], 0 * q[:, part])[0]
    return angles


class _Digital:
    """PID with a filter of 200 Hz on its derivative."""

    def __init__(self, gains: tuple[float, float, float], Ts: float) -> None:
        self.gains, self.Ts = gains, Ts
        self.keep = np.exp(-2 * np.pi * 200 * Ts)
        self.sum: Array | float = 0.0
        self.slope: Array | float = 0.0
        self.last: Array | None = None

    def __call__(self, e: Array) -> Array:
        k_p, k_i, k_d = self.gains
        self.sum = self.sum + e * self.Ts
        last = e if self.last is None else self.last
        self.slope = self.keep * self.slope + (1 - self.keep) * (e - last) / self.Ts
        self.last = e
        return np.asarray(k_p * e + k_i * self.sum + k_d * self.slope)

"""Runs of a case by inverse dynamics: motion as a controller leaves it, torque that it takes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import lfilter

from studies.generator.base import Base
from studies.generator.draw import Case, Hidden, Noise
from studies.generator.drives import DRIVES, Drive, Encoder, Motor
from studies.generator.effects import TORQUES, shape
from studies.generator.outside import OUTSIDE
from studies.generator.torques import Tilt, Torque
from studies.generator.trajectories import KINDS, RATE, WARM, Controller, Motion, instants
from tests.oracles.calculus import Array

CURRENT_LOOP = 1 / (2 * np.pi * 1000.0)
"""Lag of the drive that the machine file knows [s]: f_current."""
Kind = Torque | Motor | Drive | Encoder


@dataclass(frozen=True)
class Scaled:
    """An effect with its gain (6,), zero on the joints that are sound."""

    hidden: Hidden
    effect: Kind
    gain: Array


@dataclass(frozen=True)
class Clean:
    """All runs before the logger, (6, runs, samples); the first WARM seconds are not logged.

    clock (runs, samples) [s] since the machine was switched on; q, v, a the motion as the encoder
    shows it; i the reported torque, tau the command [N m]; contributions: what each effect puts
    between reported torque and the true base model at that motion (a drive effect: command less
    reported); rms (6,) [N m] of the base torque.
    """

    clock: Array
    q: Array
    v: Array
    a: Array
    i: Array
    tau: Array
    r: Array
    contributions: tuple[Array, ...]
    scaled: tuple[Scaled, ...]
    rms: Array
    base: Base


def make(hidden: Hidden, base: Base) -> Kind:
    """The effect that its seed draws."""
    kinds: dict[str, Callable[..., Kind]] = {**TORQUES, **DRIVES, **OUTSIDE}
    effect = kinds[hidden.id](np.random.default_rng(hidden.seed))
    if isinstance(effect, Tilt):
        return replace(effect, mechanism=base.mechanism, masses=base.p)
    return effect


def clocks(case: Case) -> Array:
    """Instants (runs, samples) since the machine was switched on, run after run."""
    t = instants(case.seconds)
    runs = len(case.trajectories) * case.passes
    return t + WARM + (case.seconds + WARM) * np.arange(runs)[:, None]


def references(case: Case) -> Motion:
    """Angles, rates, accelerations (6, trajectories, samples)."""
    t = instants(case.seconds)
    moves = [KINDS[kind](t, np.random.default_rng(seed)) for kind, seed in case.trajectories]
    q, v, a = (np.stack(parts, axis=1) for parts in zip(*moves, strict=True))
    return q, v, a


def disturbance(noise: Noise, runs: int, samples: int) -> Array:
    """Coloured torque (6, runs, samples) [N m] that never repeats."""
    rng = np.random.default_rng([noise.seed, 1])
    pole = np.exp(-2 * np.pi * noise.corner / RATE)
    white = rng.standard_normal((6, runs, samples + 4000)) * np.sqrt(1 - pole**2)
    return np.asarray(noise.coloured * lfilter([1.0], [1.0, -pole], white, axis=-1)[..., 4000:])


def scale(hidden: Hidden, base: Base, clock: Array, motion: Motion, m: Array) -> Scaled:
    """The effect at its wanted share of torque RMS on its joints, or at its physical limit."""
    effect, axes = make(hidden, base), list(hidden.axes)
    part = slice(round(WARM * RATE), None)
    wanted = hidden.size * np.sqrt(np.mean(m[..., part] ** 2, axis=(1, 2)))
    mask = np.isin(np.arange(6), axes)

    def size(gain: Array) -> Array:
        contribution = signal(effect, gain * mask, base, clock, motion, m)
        return np.asarray(np.sqrt(np.mean(contribution[..., part] ** 2, axis=(1, 2))))

    if isinstance(effect, Torque | Encoder):
        gain = 1e-3 * wanted / np.maximum(size(np.full(6, 1e-3)), 1e-12)
        if effect.everywhere:  # one angle for all joints
            gain = np.full(6, np.sqrt(np.sum(wanted**2) / np.sum((wanted / gain) ** 2)))
        return Scaled(hidden, effect, np.minimum(gain, effect.limit) * mask)
    low, high = np.full(6, 1e-7), np.full(6, min(effect.limit, 1.0))
    if effect.unit == "1/(N m)":  # a torque limit: the motion must stay possible
        high = np.minimum(high, 0.8 / np.max(np.abs(m), axis=(1, 2)))
    for _ in range(24):
        middle = np.sqrt(low * high)
        small = size(middle) < wanted
        low, high = np.where(small, middle, low), np.where(small, high, middle)
    return Scaled(hidden, effect, high * mask)


def signal(effect: Kind, gain: Array, base: Base, clock: Array, motion: Motion, m: Array) -> Array:
    """Difference (6, runs, samples) that an effect makes where the motor has to give m."""
    q, v, a = motion
    if isinstance(effect, Torque):
        return gain[:, None, None] * shape(effect, clock, q, v, a)
    if isinstance(effect, Encoder):
        return base.torque(q, v, a) - base.torque(*effect.reading(gain, q, v, a))
    if isinstance(effect, Motor):
        return effect.reported(gain, m, clock, q) - m
    return effect.command(gain, m, clock) - m


def simulate(case: Case) -> Clean:
    """All runs of a case, passes of a trajectory side by side."""
    base, nominal = Base(case.truth), Base(case.nominal)
    clock, ref = clocks(case), references(case)
    m_ref = base.torque(*ref)
    ref_m = m_ref - nominal.torque(*ref)
    q, v, a, m, torque_error = (np.repeat(x, case.passes, axis=1) for x in (*ref, m_ref, ref_m))
    scaled = tuple(scale(h, base, clock, (q, v, a), m) for h in case.hidden)
    for s in scaled:
        if isinstance(s.effect, Torque | Motor):
            torque_error = torque_error + signal(s.effect, s.gain, base, clock, (q, v, a), m)
    w = disturbance(case.noise, *clock.shape)
    motion = _followed((q, v, a), torque_error + w)
    return _composed(base, scaled, clock, motion, w, q)


def _followed(ref: Motion, whole: Array) -> Motion:
    """Motion (6, runs, samples): the reference less the error that a torque error leaves."""
    errors = [Controller().error(whole[:, k]) for k in range(whole.shape[1])]
    wide = [np.stack(parts, axis=1) for parts in zip(*errors, strict=True)]
    q, v, a = (x - e for x, e in zip(ref, wide, strict=True))
    return q, v, a


def _composed(
    base: Base, scaled: tuple[Scaled, ...], clock: Array, motion: Motion, w: Array, r: Array
) -> Clean:
    """Torques that a motion takes, from the joint back to the command, with each contribution."""
    kinds = (Torque, Motor, Drive, Encoder)
    of = {kind: [s for s in scaled if isinstance(s.effect, kind)] for kind in kinds}
    bare, contributions = base.torque(*motion), {}
    m = bare + w
    for s in of[Torque]:
        contributions[s.hidden] = signal(s.effect, s.gain, base, clock, motion, m)
        m = m + contributions[s.hidden]
    i, reading = m, motion
    for s in of[Motor]:
        contributions[s.hidden] = signal(s.effect, s.gain, base, clock, motion, i)
        i = i + contributions[s.hidden]
    for s in of[Encoder]:
        assert isinstance(s.effect, Encoder)
        reading = s.effect.reading(s.gain, *reading)
        contributions[s.hidden] = bare - base.torque(*reading)
    tau = i + CURRENT_LOOP * np.gradient(i, 1 / RATE, axis=-1)
    for s in of[Drive]:
        contributions[s.hidden] = signal(s.effect, s.gain, base, clock, motion, tau)
        tau = tau + contributions[s.hidden]
    logged = slice(round(WARM * RATE), None)
    rms = np.sqrt(np.mean(bare[..., logged] ** 2, axis=(1, 2)))
    ordered = tuple(contributions[s.hidden] for s in scaled)
    return Clean(clock, *reading, i, tau, r, ordered, scaled, rms, base)

"""Plain rotary axes: inertia, viscous and Coulomb friction, cogging; no delay anywhere.

    u = J a + d v + F_c z + sum_k h_k A cos(k n q + phase_k) + o - w

q is the reference and what a coloured torque disturbance w makes of it in the feedback,
J e'' + K_d e' + K_p e = w; z is Dahl's friction with a presliding angle far below the stroke. n is
any whole number of periods a turn from 1 to 500, the stroke 0.05 to 20 turns. Every value is of
this file alone.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import cont2discrete, lfilter

Array = NDArray[np.float64]
TURN = 2 * np.pi
MOST_ORDER, TURNS = 500, (0.05, 20.0)
LEAST_PERIODS, MOST_PERIODS = 2.0, 2000.0
"""Cogging periods over the stroke: fewer are a spring, more pass too quickly for a
log of a minute."""
PASSES, TRAJECTORIES = 2, 3
SETTLE = 0.1
"""Share of a run that the feedback has to settle in before the log begins."""


@dataclass(frozen=True)
class Case:
    """All that is drawn, arrays (n,) by axis: J [kg m2], damping [N m s/rad], friction,
    cogging, offset [N m]; width: presliding angle [rad]. order: periods a turn; heights: of the
    harmonics, relative; stroke [rad]; rate [Hz]; seconds: of a run; pace [Hz]: of the slowest
    motion; noise, disturbance: relative to the torque; encoder [rad]."""

    seed: int
    J: Array
    damping: Array
    friction: Array
    cogging: Array
    offset: Array
    width: Array
    order: int
    heights: Array
    phases: Array
    stroke: float
    rate: float
    seconds: float
    pace: float
    noise: float
    disturbance: float
    encoder: float

    @property
    def n(self) -> int:
        """Axes."""
        return len(self.J)


@dataclass(frozen=True)
class Run:
    """True position, rate, acceleration, Coulomb state and motor torque (samples, n)."""

    q: Array
    v: Array
    a: Array
    z: Array
    u: Array


def draw(seed: int) -> Case:
    """The case of a seed, always the same."""
    rng = np.random.default_rng([seed, 23])
    n = int(rng.integers(1, 4))
    while True:
        turns, order = _between(rng, *TURNS), round(_between(rng, 1, MOST_ORDER))
        if LEAST_PERIODS <= turns * order <= MOST_PERIODS:
            break
    # the wave passes with some hertz, and a run lasts two moves there and back at least
    pace = min(_between(rng, 2.0, 20.0) / (np.pi * turns * order), 1.0)
    pace = max(pace, 1 / 20)
    count = int(rng.integers(1, 4))
    J = np.array([_between(rng, 1e-3, 1.0) for _ in range(n)])
    torque = J * (turns * np.pi) * (TURN * pace) ** 2 * 2
    share = np.array([[_between(rng, 0.03, 0.3) for _ in range(n)] for _ in range(3)])
    whole = torque * _between(rng, 0.3, 3.0)
    return Case(
        seed,
        J,
        share[0] * whole / (turns * np.pi * TURN * pace),
        share[1] * whole,
        share[2] * whole,
        rng.uniform(-0.2, 0.2, n) * whole,
        turns * TURN * np.array([_between(rng, 1e-5, 1e-3) for _ in range(n)]),
        order,
        np.array([1.0, *rng.uniform(0.2, 0.6, count - 1)]),
        rng.uniform(0, TURN, (count, n)),
        turns * TURN,
        float(rng.choice([250.0, 500.0, 1000.0])),
        max(6.0, 2 / pace),
        pace,
        _between(rng, 2e-3, 1e-2),
        _between(rng, 1e-3, 1e-2),
        turns * TURN * _between(rng, 1e-8, 1e-6),
    )


def _between(rng: np.random.Generator, low: float, high: float) -> float:
    """A value of log-uniform chance."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def runs_of(case: Case) -> list[list[Run]]:
    """All runs [trajectory][pass]."""
    scale, runs = np.ones(case.n), list[list[Run]]()
    for letter in range(TRAJECTORIES):
        reference = _reference(case, letter)
        if letter == 0:
            scale = np.std(_run(case, reference, np.zeros(case.n), 0).u, axis=0)
        first = 1 + letter * PASSES
        runs.append([_run(case, reference, scale, first + k) for k in range(PASSES)])
    return runs


def _clock(case: Case) -> Array:
    return np.arange(round(case.seconds * (1 + SETTLE) * case.rate)) / case.rate


def _reference(case: Case, letter: int) -> tuple[Array, Array, Array]:
    """Position, rate, acceleration (samples, n): four waves, together as far as the stroke."""
    rng, t = np.random.default_rng([case.seed, 29, letter]), _clock(case)[:, None]
    size = rng.uniform(0.2, 1.0, (4, case.n)) * np.array([1.0, 0.5, 0.3, 0.15])[:, None]
    w = TURN * case.pace * (np.arange(1, 5)[:, None] + rng.uniform(-0.2, 0.2, (4, case.n)))
    phase = rng.uniform(0, TURN, (4, case.n))
    waves = [
        (s, f, np.sin(f * t + p), np.cos(f * t + p)) for s, f, p in zip(size, w, phase, strict=True)
    ]
    q = sum(s * sine for s, _, sine, _ in waves)
    unit = case.stroke / np.ptp(q, axis=0)
    v = sum(s * f * cosine for s, f, _, cosine in waves)
    a = sum(-s * f**2 * sine for s, f, sine, _ in waves)
    return q * unit, v * unit, a * unit


def _run(case: Case, reference: tuple[Array, Array, Array], scale: Array, number: int) -> Run:
    """A pass; scale (n,): torque RMS [N m] that the disturbance is relative to, 0: none."""
    rng = np.random.default_rng([case.seed, 31, number])
    kicks = rng.standard_normal(reference[0].shape)
    corner = float(np.exp(-TURN * _between(rng, 0.5, 20.0) / case.rate))
    w = lfilter([np.sqrt(1 - corner**2)], [1, -corner], kicks, axis=0)
    w = case.disturbance * scale * w
    bandwidth = TURN * max(20 * case.pace, 3.0)
    e, ed, edd = _answer(w / case.J, bandwidth, 1 / case.rate)
    q, v, a = (r + x for r, x in zip(reference, (e, ed, edd), strict=True))
    z = presliding(q, case.width)
    return Run(q, v, a, z, torque(case, q, v, a, z) - w)


def _answer(push: Array, bandwidth: float, step: float) -> tuple[Array, Array, Array]:
    """What a critically damped feedback leaves of a push [rad/s2]: position, rate, acceleration."""
    A = np.array([[0.0, 1.0], [-(bandwidth**2), -2 * bandwidth]])
    C, D = np.array([[1.0, 0.0], [0.0, 1.0], A[1]]), np.array([[0.0], [0.0], [1.0]])
    Ad, Bd, Cd, Dd, _ = cont2discrete((A, np.array([[0.0], [1.0]]), C, D), step)
    state, out = np.zeros((2, push.shape[1])), np.empty((3, *push.shape))
    for k, p in enumerate(push):
        out[:, k] = Cd @ state + Dd * p
        state = Ad @ state + Bd * p
    return out[0], out[1], out[2]


def presliding(q: Array, width: Array) -> Array:
    """State (samples, n) of Dahl's friction along q, exact between samples, from rest."""
    move = np.diff(q, axis=0)
    sign, left = np.sign(move), np.exp(-np.abs(move) / width)
    z = np.zeros(q.shape)
    for k in range(len(move)):
        z[k + 1] = sign[k] + (z[k] - sign[k]) * left[k]
    return z


def torque(case: Case, q: Array, v: Array, a: Array, z: Array) -> Array:
    """All but the disturbance (samples, n) [N m]."""
    rigid = case.J * a + case.damping * v + case.offset
    return np.asarray(rigid + case.friction * z + cogging(case, q))


def cogging(case: Case, q: Array) -> Array:
    """Its harmonics together (samples, n) [N m]."""
    waves = enumerate(zip(case.heights, case.phases, strict=True), start=1)
    whole = sum(h * np.cos(k * case.order * q + phase) for k, (h, phase) in waves)
    return np.asarray(case.cogging * whole)

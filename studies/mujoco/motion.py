"""References: multisines, moves from point to point, triangles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from studies.mujoco.machine import Array, Machine

KINDS = ("multisine", "points", "triangle")
FADE = 0.08
"""Share of a run at either end in which it comes from rest and back."""


@dataclass(frozen=True)
class Reference:
    """Position, rate, acceleration (samples, n), sampled every `step` [s]."""

    step: float
    r: Array
    rd: Array
    rdd: Array


def reference(kind: str, seed: int, machine: Machine, seconds: float, step: float) -> Reference:
    """A trajectory about the middle pose that begins and ends at rest. ValueError for a kind."""
    rng = np.random.default_rng([seed, 7])
    t: Array = np.arange(round(seconds / step), dtype=np.float64) * np.float64(step)
    generators = {"multisine": _multisine, "points": _points, "triangle": _triangle}
    if kind not in generators:
        raise ValueError(f"motion {kind!r}: one of {', '.join(KINDS)}")
    columns = []
    for k in range(machine.n):
        wave = generators[kind](t, machine.frequency * rng.uniform(0.7, 1.3), rng)
        wave = np.asarray(wave / max(float(np.abs(wave).max()), 1e-9) * _fade(t, seconds))
        columns.append(machine.middle[k] + machine.reach[k] * rng.uniform(0.7, 1.0) * wave)
    r = np.stack(columns, axis=1)
    rd = np.gradient(r, step, axis=0)
    return Reference(step, r, rd, np.gradient(rd, step, axis=0))


def _fade(t: Array, seconds: float) -> Array:
    s = np.clip(np.minimum(t, seconds - t) / (FADE * seconds), 0, 1)
    return np.asarray(s**3 * (10 - 15 * s + 6 * s * s))


def _multisine(t: Array, f: float, rng: np.random.Generator) -> Array:
    phases = rng.uniform(0, 2 * np.pi, 5)
    parts = [np.sin(2 * np.pi * j * f * t + p) / j for j, p in enumerate(phases, start=1)]
    return np.asarray(np.sum(parts, axis=0))


def _points(t: Array, f: float, rng: np.random.Generator) -> Array:
    period = 0.6 / f
    count = int(t[-1] / period) + 2
    goals = rng.uniform(-1, 1, count)
    number = np.minimum((t / period).astype(int), count - 2)
    s = np.clip((t / period - number) / 0.75, 0, 1)
    s = s**3 * (10 - 15 * s + 6 * s * s)
    return np.asarray(goals[number] + (goals[number + 1] - goals[number]) * s)


def _triangle(t: Array, f: float, rng: np.random.Generator) -> Array:
    phase = rng.uniform(0, 1)
    # corners rounded by taking the arcsine of a sine that falls short of one
    return np.asarray(np.arcsin(0.985 * np.sin(2 * np.pi * (0.7 * f * t + phase))))

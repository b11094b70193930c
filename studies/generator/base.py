"""The machine that has nothing hidden: mechanism and actuators, and what its parameters can do."""

from __future__ import annotations

import numpy as np

from studies.generator.effects import column
from studies.generator.masses import linear, units
from studies.generator.mechanism import Mechanism
from tests.oracles.calculus import Array
from tests.oracles.machine import Actuator, Machine


def dahl(q: Array, sigma: float) -> Array:
    """State z of [SH, Eq. (23)] along q (6, runs, samples), exact between samples, from 0."""
    move = np.diff(q, axis=-1)
    sign, kept = np.sign(move), np.exp(-np.abs(move) / sigma)
    z = np.zeros(q.shape)
    for k in range(move.shape[-1]):
        s = sign[..., k]
        z[..., k + 1] = s + (z[..., k] - s) * kept[..., k]
    return z


def chi(actuator: Actuator, q: Array, v: Array, z: Array) -> Array:
    """Actuator torque (6, ...) [N m].  [SH, Eq. (22)]"""
    total = column(actuator.o, q) + column(actuator.k, q) * q + column(actuator.d, q) * v
    total = total + column(actuator.c, q) * z
    first = np.exp(1j * actuator.omega * q)
    turn = first
    for a, b in zip(actuator.a.swapaxes(0, 1), actuator.b.swapaxes(0, 1), strict=True):
        total = total + column(a, q) * turn.real + column(b, q) * turn.imag
        turn = turn * first
    return np.asarray(total)


class Base:
    """Torque of a machine from its motion; J_rotor of the machine may be (6,)."""

    def __init__(self, machine: Machine) -> None:
        self.machine, self.mechanism, self.p = machine, Mechanism(machine), linear(machine)

    def torque(self, q: Array, v: Array, a: Array) -> Array:
        """Torque (6, runs, samples) [N m] along q, v, a of that shape."""
        act = self.machine.actuator
        runs = range(q.shape[1])
        parts = [self.mechanism.inverse(q[:, k], v[:, k], a[:, k], self.p) for k in runs]
        return np.stack(parts, axis=1) + chi(act, q, v, dahl(q, act.sigma))


def hann(signal: Array, points: int = 101) -> Array:
    """Centred Hann window over the last axis; shorter by points - 1."""
    taps = np.sin(np.pi * np.arange(1, points + 1) / (points + 1)) ** 2
    taps = taps / np.sum(taps)
    size = signal.shape[-1]
    length = 1 << (size + points).bit_length()
    both = np.fft.rfft(signal, length) * np.fft.rfft(taps, length)
    return np.asarray(np.fft.irfft(both, length)[..., points - 1 : size])


class Columns:
    """What the true model's own parameters can do to the torque: filtered, every `every` samples.

    Mechanism columns come from the torque for one unit of each inertial and elastic value (the
    torque is linear in them), actuator columns joint by joint, the Dahl width by difference.
    """

    def __init__(self, base: Base, q: Array, v: Array, a: Array, skip: int, every: int = 20):
        """q, v, a (6, runs, samples); the first `skip` samples are not looked at."""
        self.skip, self.every = skip, every
        act = base.machine.actuator
        fq, fv, fa = (self.thin(x).reshape(6, -1) for x in (q, v, a))
        pose = base.mechanism.pose(fq)
        gravity = {True: base.mechanism.g, False: np.zeros(3)}
        rows = [base.mechanism.torque(pose, fv, fa, p, gravity[_heavy(p)]) for p in units()]
        shared = np.stack([row.ravel() for row in rows], axis=1)
        z = dahl(q, act.sigma)
        tangent = (dahl(q, act.sigma * 1.01) - dahl(q, act.sigma * 0.99)) / 0.02
        own = [np.ones(q.shape), q, v, z, tangent]
        for n in range(1, act.a.shape[1] + 1):
            own += [np.cos(n * act.omega * q), np.sin(n * act.omega * q)]
        thin = np.stack([self.thin(x).reshape(6, -1) for x in own], axis=-1)
        samples, width = thin.shape[1:]
        blocks = np.zeros((6, samples, 6, width))
        blocks[range(6), :, range(6)] = thin
        wide = np.concatenate([shared, blocks.reshape(6 * samples, -1)], axis=1)
        wide = wide / np.maximum(np.linalg.norm(wide, axis=0), 1e-12)
        U, s, _ = np.linalg.svd(wide, full_matrices=False)
        self.basis = U[:, s > 1e-7 * s[0]]

    def thin(self, signal: Array) -> Array:
        """Filtered and thinned (..., runs, fewer)."""
        return hann(signal[..., self.skip :])[..., :: self.every]

    def left(self, contribution: Array) -> Array:
        """RMS (6,) [N m] of what the best parameters leave of a contribution (6, runs, samples)."""
        y = self.thin(contribution).reshape(6, -1)
        rest = y.ravel() - self.basis @ (self.basis.T @ y.ravel())
        return np.asarray(np.sqrt(np.mean(rest.reshape(y.shape) ** 2, axis=1)))


def _heavy(p: object) -> bool:
    """Whether a unit has mass: gravity acts on it; all others see none."""
    return any(np.any(getattr(p, name)) for name in ("upper", "lower", "platform"))

"""Machines drawn from a seed, from millinewtonmetres to kilonewtonmetres."""

from __future__ import annotations

import numpy as np

from studies.mujoco import hexapod
from studies.mujoco.machine import G, Link, Machine, Six, Three, six, triple

Rng = np.random.Generator
DOWN: Three = (0.0, 0.0, -G)
LEVEL: Three = (-np.pi / 2, 0.0, 0.0)
"""Turns z into the horizontal."""


def axis(rng: Rng) -> Machine:
    """A geared axis, level or upright, with a stroke of 0.05 to 20 turns."""
    mass, length = _scale(rng)
    reach = np.pi * float(10 ** rng.uniform(np.log10(0.05), np.log10(20)))
    centre = length * np.array([1.0, rng.uniform(-0.2, 0.2), rng.uniform(-0.1, 0.1)])
    own = mass * length**2
    upright = bool(rng.random() < 0.4)
    link = Link(
        (0.0, 0.0, 0.0),
        (0.0, 0.0, 0.0) if upright else LEVEL,
        mass,
        triple(centre),
        _inertia(rng, mass, length),
        own * float(10 ** rng.uniform(-1.5, 0.5)),
    )
    # accelerations whose torque is about that of gravity
    share = own / (own + link.armature)
    swing = np.sqrt(G * share / (length * reach)) / (2 * np.pi)
    frequency = float(np.clip(rng.uniform(0.3, 0.9) * swing, 0.08, 3.0))
    middle = 0.0 if reach > np.pi else float(rng.uniform(-np.pi, np.pi))
    return Machine("axis", (link,), DOWN, (middle,), (reach,), frequency)


def gantry(rng: Rng) -> Machine:
    """Two or three linear axes at right angles; the third stands upright."""
    n, size = int(rng.integers(2, 4)), float(10 ** rng.uniform(-1.7, 0.3))
    mass = float(10 ** rng.uniform(-2, 2.7))
    frames: tuple[Three, ...] = ((0.0, np.pi / 2, 0.0), LEVEL, (0.0, -np.pi / 2, 0.0))
    links = []
    for k in range(n):
        own = mass * 0.6**k * float(rng.uniform(0.7, 1.4))
        centre = 0.3 * size * rng.uniform(-1, 1, 3)
        rotor = own * float(10 ** rng.uniform(-1.5, 0.0))
        inertia = _inertia(rng, own, size)
        frame = (frames[k][0], frames[k][1], frames[k][2])
        links.append(Link((0.0,) * 3, frame, own, triple(centre), inertia, rotor, "slide"))
    reach = tuple(size * float(rng.uniform(0.4, 1.0)) for _ in range(n))
    speedup = float(10 ** rng.uniform(-0.3, 0.8))
    frequency = float(np.clip(np.sqrt(speedup / max(reach)) / (2 * np.pi), 0.1, 3.0))
    return Machine("gantry", tuple(links), DOWN, (0.0,) * n, reach, frequency)


def arm(rng: Rng) -> Machine:
    """Three to six axes: upright, shoulder, elbow, roll, wrist, roll."""
    n = int(rng.choice([3, 4, 5, 6, 6]))
    mass, length = _scale(rng)
    turn = np.pi / 2
    places = (
        ((0.0, 0.0, 0.5), (0.0, 0.0, 0.0)),
        ((0.1, 0.0, 0.0), (-turn, 0.0, 0.0)),
        ((1.0, 0.0, 0.0), (0.0, 0.0, 0.0)),
        ((0.1, 0.0, 0.0), (0.0, turn, 0.0)),
        ((0.0, 0.0, 0.8), (0.0, -turn, 0.0)),
        ((0.1, 0.0, 0.0), (0.0, turn, 0.0)),
    )
    centres = (
        (0, 0.1, 0.1),
        (0.5, 0, 0.1),
        (0.1, 0.1, 0),
        (0, 0.05, 0.4),
        (0.1, 0.1, 0),
        (0, 0.05, 0.1),
    )
    links = []
    for k in range(n):
        own = mass * 0.7**k * float(rng.uniform(0.7, 1.4))
        at = length * np.array(places[k][0]) * rng.uniform(0.8, 1.2)
        rpy = np.array(places[k][1]) + rng.normal(0, 0.01, 3)
        centre = length * (np.array(centres[k]) + 0.03 * rng.standard_normal(3))
        size = length * (0.6 if k < 4 else 0.3)
        rotor = own * size**2 * float(10 ** rng.uniform(-1.0, 0.3))
        inertia = _inertia(rng, own, size)
        links.append(Link(triple(at), triple(rpy), own, triple(centre), inertia, rotor))
    middle = (0.0, -0.7, 1.2, 0.2, 0.8, 0.0)[:n]
    reach = tuple(float(rng.uniform(0.3, 1.2)) for _ in range(n))
    swing = np.sqrt(G / (2 * length * float(np.mean(reach)))) / (2 * np.pi)
    frequency = float(np.clip(rng.uniform(0.3, 0.8) * swing, 0.1, 2.0))
    return Machine("arm", tuple(links), DOWN, middle, reach, frequency)


def _scale(rng: Rng) -> tuple[float, float]:
    """Mass [kg] and length [m] of machines whose gravity makes 1 mN m to 1 kN m."""
    torque = float(10 ** rng.uniform(-3, 3))
    length = 0.2 * torque**0.25 * float(10 ** rng.uniform(-0.15, 0.15))
    return torque / (G * length), length


def _inertia(rng: Rng, mass: float, size: float) -> Six:
    """Inertia of a cloud of points about its centre."""
    cloud = rng.standard_normal((6, 3)) * size * rng.uniform(0.1, 0.35, 3)
    cloud -= cloud.mean(axis=0)
    J = sum((p @ p * np.eye(3) - np.outer(p, p) for p in cloud), np.zeros((3, 3)))
    return six(np.asarray(J) * mass / 6)


def closed(rng: Rng) -> Machine:
    """A hexapod with cranks."""
    chain = hexapod.drawn(rng)
    reach = tuple(0.19 * float(rng.uniform(0.6, 1.0)) for _ in range(6))
    frequency = float(rng.uniform(0.25, 0.6) / np.sqrt(chain.L))
    return Machine("hexapod", (), DOWN, (0.0,) * 6, reach, min(frequency, 2.0), chain)


KINDS = {"axis": axis, "gantry": gantry, "arm": arm, "hexapod": closed}

"""Seeded joint motions and machines for the tests."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tests.oracles.calculus import Array
from tests.oracles.machine import Body, Machine


def random_motion(seed: int) -> tuple[Array, Array, Array]:
    """theta, thetad, thetadd (6,) of a brisk motion: torques of 10 to 20 N m."""
    rng = np.random.default_rng(seed)
    return rng.uniform(-0.3, 0.3, 6), rng.uniform(-3.0, 3.0, 6), rng.uniform(-200.0, 200.0, 6)


def random_bodies(machine: Machine, seed: int) -> Machine:
    """The same geometry with bodies and stiffness that have no symmetry and no zero in them."""
    rng = np.random.default_rng(seed)

    def body() -> Body:
        # a cloud of points is physical whatever their places
        r = rng.normal(0.0, 0.1, (8, 3)) + rng.uniform(-0.1, 0.2, 3)
        m = rng.uniform(0.05, 0.3, 8)
        c = m @ r / m.sum()
        d = r - c
        Ic = np.sum(d * d * m[:, None]) * np.eye(3) - (d * m[:, None]).T @ d
        return Body(float(m.sum()), c, Ic)

    return replace(
        machine,
        upper=body(),
        lower=body(),
        end_effector=body(),
        J_rotor=float(rng.uniform(0.001, 0.01)),
        k_u=rng.uniform(0.2, 1.0, 2),
        k_s=rng.uniform(0.2, 1.0, 2),
    )

"""Motions with all their coordinates for the tests of the blocks behind the kinematics."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tests.blocks.loaded import load

Array = NDArray[np.float64]


class Instant(NamedTuple):
    """x, xd, xdd (37,) of a closed pose and Dahl states z (6,)."""

    x: Array
    xd: Array
    xdd: Array
    z: Array


def random_instants(count: int, seed: int, brisk: float = 1.0) -> Iterator[Instant]:
    """Poses within +-0.2 rad, up to 2 rad/s and 40 rad/s2 times `brisk`, unrelated in time."""
    rng, block = np.random.default_rng(seed), load("kinematics")
    block.start(corrections=2)
    for _ in range(count):
        theta = rng.uniform(-0.2, 0.2, 6)
        thetad, thetadd = brisk * rng.uniform(-2, 2, 6), brisk * rng.uniform(-40, 40, 6)
        y = block.tick(theta=theta, thetad=thetad, thetadd=thetadd)
        if y["converged"] == 1.0:
            yield Instant(y["x"], y["xd"], y["xdd"], rng.uniform(-1, 1, 6))

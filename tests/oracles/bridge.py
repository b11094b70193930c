"""What the tests need to hold the model in fmus.common against the oracles."""

from __future__ import annotations

from collections.abc import Callable

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from tests.oracles import actuator, geometry
from tests.oracles.machine import Machine
from tests.oracles.motions import random_motion

Array = NDArray[np.float64]
Numeric = Callable[..., Array]
Motion = tuple[Array, Array, Array]


def compiled(sizes: list[int], build: Callable[..., ca.SX]) -> Numeric:
    """`build` of symbols as a function of arrays; a column comes back as a vector."""
    symbols = [ca.SX.sym(f"s{k}", n) for k, n in enumerate(sizes)]
    function = ca.Function("f", symbols, [ca.densify(build(*symbols))])

    def call(*values: Array) -> Array:
        out = np.array(function(*values))
        return out[:, 0] if out.shape[1] == 1 else out

    return call


def same_quaternions(x: Array, like: Array) -> Array:
    """x (37,) with the sign of each quaternion as in `like`: lam and -lam turn alike."""
    x = x.copy()
    for start in (*range(6, 30, 4), 33):
        part = slice(start, start + 4)
        x[part] *= np.sign(x[part] @ like[part])
    return x


class Paths:
    """Closed random motions of one machine, each computed once."""

    def __init__(self, machine: Machine, x0: Array) -> None:
        # each quaternion with the sign that x0 gives it
        ones = geometry.neutral(machine)
        self.machine, self.signs = machine, np.where(same_quaternions(ones, x0) == ones, 1, -1)
        self.known: dict[int, Motion] = {}

    def __call__(self, seed: int) -> Motion:
        """x, xd, xdd (37,) of `random_motion(seed)`."""
        if seed not in self.known:
            x, xd, xdd = geometry.motion(self.machine, *random_motion(seed))
            self.known[seed] = (x * self.signs, xd * self.signs, xdd * self.signs)
        return self.known[seed]


def z_of(seed: int) -> Array:
    """Dahl states (6,) for a seed."""
    return np.random.default_rng(1000 + seed).uniform(-1, 1, 6)


def chi_of(machine: Machine, theta: Array, z: Array) -> Array:
    """Actuator basis (114,)."""
    return actuator.basis(machine.actuator.omega, 9, theta, z)

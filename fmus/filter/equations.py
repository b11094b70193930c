"""Measurement filter W: taps (27), derivative stencils of IV-D, actuator basis and Dahl state."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from flexhex.fmus.common import actuator
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.model.effect_bank import Bank, columns_function, followers
from flexhex.fmus.common.model.model import Model


def hann_window(at: NDArray[np.float64], length: float) -> NDArray[np.float64]:
    """Hann window over [0, length] at the places `at`, largest value 1, zero outside.

    sin^2(pi at / length)
    """
    inside = np.maximum(np.minimum(at, length - at), 0)
    return np.asarray(np.sin(np.pi * inside / length) ** 2)


def hann(points: int) -> NDArray[np.float64]:
    """Taps of W (points,), the newest sample's first.  [SH, Eq. (27)]

        w_n = sin^2(pi n / points) / sum

    The print has no division; its 101 taps sum to 50.5. They delay by points / 2 samples:
    w_0 = 0 and w_n = w_(points - n).
    """
    taps = hann_window(np.arange(points, dtype=np.float64), points)
    normalised: NDArray[np.float64] = taps / taps.sum()
    return normalised


def derivatives(past: Any, now: Any, latest: Any, Ts: Any) -> tuple[Any, Any]:
    """First and second derivative at `now` from three samples, SX or arrays.  [SH, IV-D]

        [-1, 0, 1] / (2 Ts),  [1, -2, 1] / Ts^2

    The second is printed with its sign turned.
    """
    return (latest - past) / (2 * Ts), ((latest - now) - (now - past)) / Ts**2


def functions(machine: Machine) -> list[ca.Function]:
    """Functions of step.c.

    filter_taps() -> taps (points,)
    filter_derivatives(past, now, latest, Ts) -> thetad, thetadd (6,)
    filter_basis(theta, z) -> chi (114,): z, cos, sin, ... joint by joint
    filter_dahl(z, theta_last, theta) -> z_next (6,)
    with effects, from `effect_bank`: filter_effect_columns, _start, _advance
    """
    n, a = machine.n_arms, machine.actuator
    past, now, latest, Ts = (
        *(ca.SX.sym(name, n) for name in ("past", "now", "latest")),
        ca.SX.sym("Ts"),
    )
    theta, theta_last, z = (ca.SX.sym(name, n) for name in ("theta", "theta_last", "z"))
    z_next = [actuator.dahl(z[i], theta[i] - theta_last[i], a.sigma) for i in range(n)]
    return [
        ca.Function("filter_taps", [], [ca.SX(hann(machine.control.hann_points))], [], ["taps"]),
        ca.Function(
            "filter_derivatives",
            [past, now, latest, Ts],
            ca.cse(list(derivatives(past, now, latest, Ts))),
            ["past", "now", "latest", "Ts"],
            ["thetad", "thetadd"],
        ),
        ca.Function(
            "filter_basis",
            [theta, z],
            [ca.cse(Model(machine).basis(theta, z))],
            ["theta", "z"],
            ["chi"],
        ),
        ca.Function(
            "filter_dahl",
            [z, theta_last, theta],
            [ca.vertcat(*z_next)],
            ["z", "theta_last", "theta"],
            ["z_next"],
        ),
        *effects(Bank.compensated(machine)),
    ]


def effects(bank: Bank) -> list[ca.Function]:
    """Functions of effects.h; none without effects."""
    if not bank:
        return []
    return [columns_function(bank, "filter_effect_columns"), *followers(bank, "filter")]

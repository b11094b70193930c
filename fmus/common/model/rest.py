"""The nominal machine at rest in its neutral pose: what the inputs of the FMUs start at."""

from __future__ import annotations

from functools import lru_cache

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.model.effect_bank import SIGNALS, Bank, columns_function
from flexhex.fmus.common.model.model import Model
from flexhex.fmus.common.model.parameters import ACTUATOR, base_parameters

DIGITS = 6
"""Decimals of the torque [N m]: a thousandth of a current step, and far from the last bit, in
which the mathematics libraries of computers differ."""


def basis_at_rest(machine: Machine) -> NDArray[np.float64]:
    """Actuator basis chi of all joints, then the columns of the effects: all is zero, and always
    has been."""
    harmonics = machine.actuator.n_harmonics
    joints = np.tile([0.0, *(1.0, 0.0) * harmonics], machine.n_arms)
    bank = Bank.compensated(machine)
    if not bank:
        return joints
    columns = columns_function(bank, "columns")
    still = np.zeros(len(SIGNALS) * bank.n + 1)
    at_rest = columns(still, ca.DM(bank.start(ca.SX.zeros(bank.n))))
    return np.concatenate([joints, np.array(at_rest).ravel()])


def basis_names(machine: Machine) -> tuple[str, ...]:
    """Names of `basis_at_rest`: `actuator[1].z`, `actuator[1].cos[1]`, ..., the effects' gains."""
    orders = range(1, machine.actuator.n_harmonics + 1)
    waves = [f"{wave}[{k}]" for k in orders for wave in ("cos", "sin")]
    joints = [
        f"{ACTUATOR}[{i}].{term}" for i in range(1, machine.n_arms + 1) for term in ("z", *waves)
    ]
    return (*joints, *Bank.compensated(machine).names)


@lru_cache
def holding_torque(machine: Machine) -> tuple[float, ...]:
    """Torque of each motor (n,) [N m] that holds the pose, to DIGITS.  [SH, Eq. (24)]"""
    model = Model(machine)
    x, rest = ca.SX(model.frames.x0), ca.SX.zeros(model.n_x)
    chi, p = ca.SX(basis_at_rest(machine)), ca.SX(base_parameters(machine))
    torque = ca.evalf(model.inverse_dynamics(x, rest, rest, chi, p))
    return tuple(np.round(np.array(torque).ravel(), DIGITS).tolist())

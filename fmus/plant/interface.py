"""Variables and sample time of the plant FMU."""

from __future__ import annotations

from typing import Any

import numpy as np

from flexhex.fmus.common.interface import Interface, Variable
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.model.bodies import mechanism_names, mechanism_units, nominal_mechanism
from flexhex.fmus.common.model.effect_bank import Bank
from flexhex.fmus.common.model.geometry import Frames
from flexhex.fmus.common.model.parameters import actuator_parameters, base_parameters
from flexhex.fmus.plant.effects import SUBSTEPS, constants

MAX_DELAY = 40
"""Longest extra delay of drive or sensor, in base steps (10 ms)."""


def parameters(machine: Machine) -> tuple[Variable, ...]:
    """What can be set before the start: mechanism, actuators, drives, encoders, integrator."""
    n, drive, base = machine.n_arms, machine.drive, machine.timing.base
    listed = actuator_parameters(machine)
    full = np.array(nominal_mechanism(machine).vector()).ravel()
    delay: dict[str, Any] = {"unit": "1", "min": 0, "max": MAX_DELAY}
    return (
        Variable(
            "mechanism",
            "parameter",
            "1",
            "inertias and stiffness of every arm, end-effector",
            start=full,
            size=len(full),
            min=-100,
            max=100,
            elements=mechanism_names(n, machine.has_platform),
            units=mechanism_units(n, machine.has_platform),
        ),
        Variable(
            "actuator",
            "parameter",
            "1",
            "torque terms of every actuator",
            start=base_parameters(machine)[: len(listed)],
            size=len(listed),
            min=-100,
            max=100,
            elements=tuple(par.name for par in listed),
            units=tuple(par.unit for par in listed),
        ),
        Variable(
            "substeps",
            "parameter",
            "1",
            "integration steps a Ts, whole",
            start=1,
            min=1,
            max=SUBSTEPS,
        ),
        Variable(
            "f_current", "parameter", "Hz", "current loop", start=drive.f_current, min=1, max=1e5
        ),
        Variable(
            "tau_max", "parameter", "N m", "torque limit", start=drive.tau_max, min=0, max=1e4
        ),
        Variable(
            "tau_step",
            "parameter",
            "N m",
            "torque of one current step, 0: none",
            start=drive.K_t * drive.I_step,
            min=0,
            max=10,
        ),
        Variable(
            "theta_step",
            "parameter",
            "rad",
            "encoder step, 0: none",
            start=machine.encoder.step,
            min=0,
            max=0.1,
            display="urad",
        ),
        Variable(
            "command_delay",
            "parameter",
            description="extra delay of the command in Ts, whole",
            start=round(drive.t_command / base),
            **delay,
        ),
        Variable(
            "measurement_delay",
            "parameter",
            description="extra delay of angle and torque in Ts, whole",
            start=round(drive.t_measurement / base),
            **delay,
        ),
        Variable(
            "stroke",
            "parameter",
            "rad",
            "end stops at +-stroke",
            start=machine.geometry.stroke,
            min=0.01,
            max=1.5,
        ),
    )


def gains(machine: Machine) -> tuple[Variable, ...]:
    """Gains of the effects; nothing without effects."""
    bank = Bank.real(machine)
    if not bank:
        return ()
    return (
        Variable(
            "effect",
            "parameter",
            "1",
            "gains of the effects",
            start=bank.values,
            size=bank.n_gains,
            min=-1e4,
            max=1e4,
            elements=bank.names,
            units=bank.units,
        ),
    )


def pose(machine: Machine) -> tuple[Variable, ...]:
    """Where E is, for plots; nothing without a platform."""
    if not machine.has_platform:
        return ()
    x_E0 = machine.platform.x_E0
    return (
        Variable("x_E", "output", "m", "position of E, exact", size=3, start=x_E0),
        Variable("phi_E", "output", "rad", "rotation vector of E, exact", size=3),
    )


def interface(machine: Machine) -> Interface:
    """Drives, motors, mechanism, encoders: torque command in, angles and torque out."""
    n, x0 = machine.n_arms, Frames.of(machine).x0
    variables = (
        *parameters(machine),
        *gains(machine),
        Variable("tau", "input", "N m", "torque command", size=n, min=-1e4, max=1e4),
        Variable("payload", "input", "kg", "mass at c_payload of E", min=0, max=50),
        Variable("theta", "output", "rad", "actuator angles as the encoders read them", size=n),
        Variable(
            "tau_meas", "output", "N m", "motor torque as the drives read it, same instant", size=n
        ),
        *pose(machine),
        Variable("end_stop", "output", "1", "1: an end stop holds the mechanism", min=0, max=1),
    )
    n_p = len(actuator_parameters(machine))
    return Interface(
        "plant",
        "Six drives with motors, encoders and flexures, the mechanism, the payload",
        machine.timing.base,
        variables,
        {
            "N": n,
            "N_D": len(x0) - n,
            "N_MECHANISM": len(mechanism_names(n, machine.has_platform)),
            "N_ACTUATOR": n_p,
            "MAX_DELAY": MAX_DELAY,
            "HIDDEN": 0,
            **constants(machine),
        },
    )

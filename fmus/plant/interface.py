"""Variables and sample time of the plant FMU."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexhex.fmus.common.interface import Interface, Item, Variable, count, flag, parameter
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.model.bodies import (
    mechanism_names,
    mechanism_units,
    nominal_mechanism,
    positive,
)
from flexhex.fmus.common.model.effect_bank import Bank
from flexhex.fmus.common.model.geometry import AXES, Frames
from flexhex.fmus.common.model.parameters import ACTUATOR, actuator_parameters, base_parameters
from flexhex.fmus.common.model.rest import holding_torque
from flexhex.fmus.plant.effects import SUBSTEPS, constants

MAX_DELAY = 40
"""Longest extra delay of drive or sensor, in base steps (10 ms)."""


QUANTUM = "torque of one current step, 0: no quantisation"
ENCODER = "step of the encoder, 0: no quantisation"


def parameters(machine: Machine) -> tuple[Variable, ...]:
    """Parameters: mechanism, actuators, drives, encoders, integrator."""
    n, drive, base = machine.n_arms, machine.drive, machine.timing.base
    listed = actuator_parameters(machine)
    bodies = _vector(
        "mechanism",
        "inertias and stiffness of every arm, end-effector",
        np.array(nominal_mechanism(machine).vector()).ravel(),
        mechanism_names(n, machine.has_platform),
        mechanism_units(n, machine.has_platform),
    )
    actuators = _vector(
        ACTUATOR,
        "torque terms of every actuator",
        base_parameters(machine)[: len(listed)],
        tuple(par.name.removeprefix(ACTUATOR) for par in listed),
        tuple(par.unit for par in listed),
    )
    return (
        bodies,
        actuators,
        count("substeps", "integration steps per Ts", 1, 1, SUBSTEPS),
        parameter("f_current", "Hz", "bandwidth of the current loop", drive.f_current, 1, 1e5),
        parameter("tau_max", "N m", "torque limit", drive.tau_max, 0, 1e4),
        parameter("tau_step", "N m", QUANTUM, drive.K_t * drive.I_step, 0, 10),
        parameter("theta_step", "rad", ENCODER, machine.encoder.step, 0, 0.1, display="urad"),
        _delay("command_delay", "the command", drive.t_command / base),
        _delay("measurement_delay", "angle and torque readings", drive.t_measurement / base),
        parameter("stroke", "rad", "end stops at +-stroke", machine.geometry.stroke, 0.01, 1.5),
    )


def _delay(name: str, what: str, steps: float) -> Variable:
    return count(name, f"extra delay of {what} in multiples of Ts", round(steps), 0, MAX_DELAY)


def _vector(
    name: str,
    text: str,
    start: NDArray[np.float64],
    names: tuple[str, ...],
    units: tuple[str, ...],
) -> Variable:
    """Unlike values in one array; none of a body below what nature allows."""
    least = tuple(0.0 if positive(name) else -100.0 for name in names)
    return parameter(
        name, "1", text, start, -100, 100,
        size=len(start), elements=names, units=units, least=least,
    )  # fmt: skip


def gains(machine: Machine) -> tuple[Variable, ...]:
    """Gains of the effects; nothing without effects."""
    bank = Bank.all(machine)
    if not bank:
        return ()
    named: dict[str, Any] = {"elements": bank.names, "units": bank.units}
    return (
        parameter(
            "effect",
            "1",
            "gains of the effects",
            bank.values,
            -1e4,
            1e4,
            size=bank.n_gains,
            **named,
        ),
    )


def pose(machine: Machine) -> tuple[Variable, ...]:
    """Where E is, for plots; nothing without a platform."""
    if not machine.has_platform:
        return ()
    x_E0 = machine.platform.x_E0
    return (
        Variable("x_E", "output", "m", "position of E, exact", 3, x_E0, elements=AXES),
        Variable("phi_E", "output", "rad", "rotation vector of E, exact", 3, elements=AXES),
    )


def interface(machine: Machine) -> Interface:
    """Drives, motors, mechanism, encoders: torque command in, angles and torque out."""
    n, x0 = machine.n_arms, Frames.of(machine).x0
    variables = (
        *parameters(machine),
        *gains(machine),
        Variable(
            "tau",
            "input",
            "N m",
            "torque command",
            n,
            holding_torque(machine),
            min=-1e4,
            max=1e4,
        ),
        Variable("payload", "input", "kg", "mass at c_payload of E", min=0, max=50),
        Variable("theta", "output", "rad", "actuator angles, encoder reading", size=n),
        Variable(
            "tau_meas", "output", "N m", "motor torque, drive reading at the same instant", size=n
        ),
        *pose(machine),
        flag("end_stop", "output", "the mechanism is at an end stop", 0),
    )
    n_p = len(actuator_parameters(machine))
    return Interface(
        "plant",
        "Six drives with motors, encoders and flexures, the mechanism, the payload; rests at the"
        " torque that tau starts at",
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
        (
            Item("end_stop", "end stop reached, the mechanism rests there"),
            Item("diverged", "integration diverged: raise substeps"),
        ),
    )

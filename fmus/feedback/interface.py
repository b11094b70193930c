"""Variables and sample time of the feedback FMU (C in the loop)."""

from __future__ import annotations

from typing import Any

from flexhex.fmus.common.interface import Interface, Item, Variable, parameter
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.model.rest import holding_torque
from flexhex.fmus.feedback.design import design

MAX_DELAY = 64
"""Longest delay of the reference, in steps of Ts."""
DEFAULT_DELAY = 6.64
"""Delay of the default schedule and drive; the system description sets it anew."""


def parameters(machine: Machine) -> tuple[Variable, ...]:
    """Gains as designed, limits of the drive, the delay that makes r meet theta.

    Tunable parameters are read at every tick; the others are used at the start.
    """
    gains, drive = design(machine), machine.drive
    delay = "delay of r in multiples of Ts, may be fractional"
    quantum = "torque of one current step, the remainder is added to the next command; 0: none"
    tunable: dict[str, Any] = {"variability": "tunable"}
    return (
        parameter(
            "kp", "N m/rad", "proportional gain", gains.kp, 0, 1e6, size=machine.n_arms, **tunable
        ),
        parameter("t_i", "s", "integral time", gains.t_i, 1e-4, 1e6, **tunable),
        parameter("t_d", "s", "derivative time", gains.t_d, 0, 100, **tunable),
        parameter("t_f", "s", "lag of the derivative", gains.t_f, 1e-5, 100, **tunable),
        parameter("ff_gain", "1", "factor of tau_ff in the sum", 1, 0, 1, **tunable),
        parameter("reference_delay", "1", delay, DEFAULT_DELAY, 0, MAX_DELAY),
        parameter("tau_max", "N m", "torque limit", drive.tau_max, 1e-3, 1e4),
        parameter("tau_step", "N m", quantum, drive.K_t * drive.I_step, 0, 10),
        parameter(
            "e_max", "rad", "largest tracking error; beyond it fault is 3", 0.2, 1e-6, 10, **tunable
        ),
    )


def interface(machine: Machine) -> Interface:
    """Feedback of a machine: reference, angle and feedforward in, torque command out."""
    n = machine.n_arms
    reach = round(1.15 * machine.geometry.stroke, 6)
    variables = (
        *parameters(machine),
        Variable("r", "input", "rad", "reference angles", size=n, min=-reach, max=reach),
        Variable("theta", "input", "rad", "measured angles", size=n, min=-reach, max=reach),
        Variable(
            "tau_ff",
            "input",
            "N m",
            "feedforward torques",
            n,
            holding_torque(machine),
            min=-1e4,
            max=1e4,
        ),
        Variable("tau", "output", "N m", "torque command, within the limit", size=n),
        Variable(
            "tau_fb", "output", "N m", "torque of the PID controllers, before the limit", size=n
        ),
        Variable(
            "e",
            "output",
            "rad",
            "tracking error: delayed r - theta",
            size=n,
            display="urad",
            nominal=1e-3,
        ),
    )
    return Interface(
        "feedback",
        "Six PID controllers, delay of the reference, sum with the feedforward [SH, IV-C]",
        machine.timing.base,
        variables,
        {"N": n, "MAX_DELAY": MAX_DELAY},
        (
            Item("torque_limit", "torque limit reached in a joint"),
            Item("tracking_error", "tracking error beyond e_max in a joint"),
        ),
    )

"""Variables and sample time of the feedback FMU (C in the loop)."""

from __future__ import annotations

from dataclasses import replace

from flexhex.fmus.common.interface import Interface, Variable
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.feedback.design import design

MAX_DELAY = 64
"""Longest delay of the reference, in steps of Ts."""
DEFAULT_DELAY = 6.64
"""Delay of the default schedule and drive; the system description sets it anew."""


def _fixed(name: str, unit: str, text: str, start: float, low: float, high: float) -> Variable:
    return Variable(name, "parameter", unit, text, start=start, min=low, max=high)


def _tunable(name: str, unit: str, text: str, start: float, low: float, high: float) -> Variable:
    return replace(_fixed(name, unit, text, start, low, high), variability="tunable")


def parameters(machine: Machine) -> tuple[Variable, ...]:
    """Gains as designed, limits of the drive, the delay that makes r meet theta.

    Tunable is what a tick reads and no start prepares.
    """
    gains, drive = design(machine), machine.drive
    delay = "delay of r in steps of Ts, may be fractional"
    quantum = "torque of one current step, the rest is carried on; 0: none"
    return (
        Variable(
            "kp",
            "parameter",
            "N m/rad",
            "proportional gain",
            machine.n_arms,
            gains.kp,
            min=0,
            max=1e6,
            variability="tunable",
        ),
        _tunable("t_i", "s", "integral time", gains.t_i, 1e-4, 1e6),
        _tunable("t_d", "s", "derivative time", gains.t_d, 0, 100),
        _tunable("t_f", "s", "lag of the derivative", gains.t_f, 1e-5, 100),
        _tunable("ff_gain", "1", "share of tau_ff that is added", 1, 0, 1),
        _fixed("reference_delay", "1", delay, DEFAULT_DELAY, 0, MAX_DELAY),
        _fixed("tau_max", "N m", "torque limit", drive.tau_max, 1e-3, 1e4),
        _fixed("tau_step", "N m", quantum, drive.K_t * drive.I_step, 0, 10),
        _tunable("e_max", "rad", "following error beyond which fault is 3", 0.2, 1e-6, 10),
    )


def interface(machine: Machine) -> Interface:
    """Feedback of a machine: reference, angle and feedforward in, torque command out."""
    n = machine.n_arms
    reach = round(1.15 * machine.geometry.stroke, 6)
    variables = (
        *parameters(machine),
        Variable("r", "input", "rad", "reference angles", size=n, min=-reach, max=reach),
        Variable("theta", "input", "rad", "measured angles", size=n, min=-reach, max=reach),
        Variable("tau_ff", "input", "N m", "feedforward torques", size=n, min=-1e4, max=1e4),
        Variable("tau", "output", "N m", "torque command, within the limit", size=n),
        Variable("tau_fb", "output", "N m", "feedback's share, before the limit", size=n),
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
    )

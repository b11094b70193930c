"""Variables and sample time of the reference FMU, the source of an experiment."""

from __future__ import annotations

from flexhex.fmus.common.interface import Interface, Item, Variable, count, parameter
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.reference.equations import MAX_SINES

KINDS = (
    Item("setpoints", "random setpoints"),
    Item("triangle", "slow triangle"),
    Item("multisine", "sum of sines"),
    Item("chirp", "sine of rising frequency"),
    Item("hold", "hold at zero"),
)
MAX_PAYLOADS = 8
"""Longest payload schedule, in changes of the mass."""
MAX_PAYLOAD = 50.0
"""Largest payload [kg]."""


def schedule(machine: Machine) -> tuple[Variable, ...]:
    """Which trajectory, how often and how far; amplitude is limited to the stroke."""
    ref, stroke = machine.reference, machine.geometry.stroke
    return (
        parameter("kind", "1", "trajectory", 0, 0, 4, type="Enumeration", items=KINDS),
        parameter("seed", "1", "seed of setpoints and phases, whole", 1, 0, 2.0**53),
        parameter(
            "amplitude",
            "rad",
            "largest |r| of each joint",
            ref.amplitude,
            0,
            stroke,
            size=machine.n_arms,
        ),
        parameter("t_start", "s", "hold at zero before the first pass, whole Ts", 2, 0, 1e4),
        parameter("duration", "s", "length of one pass, whole Ts", ref.duration, 1e-3, 1e5),
        count("passes", "number of passes", 3, 1, 1_000_000),
    )


def shapes(machine: Machine) -> tuple[Variable, ...]:
    """What the kinds need: random, triangle, multisine, chirp."""
    ref = machine.reference
    return (
        parameter("period", "s", "time from setpoint to setpoint, whole Ts", ref.period, 1e-3, 1e4),
        parameter("move", "s", "time of the move to a setpoint", ref.move, 1e-3, 1e4),
        parameter("speed", "rad/s", "triangle: speed between its corners", 0.05, 1e-4, 10),
        parameter("rounding", "rad/s2", "triangle: acceleration in its corners", 1, 1e-3, 1e4),
        parameter("fade", "s", "multisine, chirp: fading in and out", 1, 1e-3, 1e4),
        parameter("f_base", "Hz", "multisine: lowest frequency", 0.1, 1e-3, 100),
        count("n_sines", "multisine: sines at 1, 2, ... f_base", 10, 1, MAX_SINES),
        parameter("f0", "Hz", "chirp: frequency at its begin", 0.1, 0, 500),
        parameter("f1", "Hz", "chirp: frequency at its end", 3, 0, 500),
    )


def payloads() -> tuple[Variable, ...]:
    """Schedule of the payload, in time since the start of the simulation."""

    def entries(name: str, unit: str, text: str, high: float) -> Variable:
        return Variable(name, "parameter", unit, text, MAX_PAYLOADS, min=0, max=high)

    return (
        count("payload_count", "entries of the schedule in use", 0, 0, MAX_PAYLOADS),
        entries("payload_time", "s", "when each mass comes, ascending", 1e6),
        entries("payload_mass", "kg", "mass from then on", MAX_PAYLOAD),
    )


def interface(machine: Machine) -> Interface:
    """Experiment of a machine: nothing in, reference motion and payload out."""
    n = machine.n_arms
    variables = (
        *schedule(machine),
        *shapes(machine),
        *payloads(),
        Variable("r", "output", "rad", "reference angles", size=n),
        Variable("rd", "output", "rad/s", "their rates", size=n),
        Variable("rdd", "output", "rad/s2", "their accelerations", size=n),
        Variable("payload", "output", "kg", "mass at the end-effector", min=0, max=MAX_PAYLOAD),
    )
    return Interface(
        "reference",
        "Reference motion of an experiment: setpoints, triangle, multisine, chirp; payload",
        machine.timing.base,
        variables,
        {"N": n, "MAX_SINES": MAX_SINES, "MAX_PAYLOADS": MAX_PAYLOADS},
    )

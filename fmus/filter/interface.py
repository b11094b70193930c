"""Variables and sample time of the filter FMU (W in the loop)."""

from __future__ import annotations

from flexhex.fmus.common.interface import Interface, Variable, count, flag, parameter
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.model.effect_bank import Bank
from flexhex.fmus.common.model.rest import basis_at_rest, basis_names, holding_torque

MAX_ALIGNMENT = 20
"""Longest extra delay of tau_f and chi_f, in samples."""


def switches() -> tuple[Variable, ...]:
    """Parameters of the filter."""
    alignment = "delay of tau_f and chi_f in samples: that of the kinematics after the filter"
    basis = "true: filtered basis of the raw angle; false: basis at the filtered angle, as in [SH]"
    play = (
        "half width of the backlash between an angle and its Dahl state: four standard deviations"
        " of the angle's noise; 0: none"
    )
    return (
        count("alignment", alignment, 1, 0, MAX_ALIGNMENT),
        flag("basis", "parameter", basis, 1),
        parameter("play", "rad", play, 0, 0, 1e-3, display="urad"),
    )


def interface(machine: Machine) -> Interface:
    """Filter of a machine: raw angles and torques in, filtered signals of one instant out."""
    n, n_basis = machine.n_arms, 1 + 2 * machine.actuator.n_harmonics
    chi = basis_at_rest(machine)
    reach = round(1.15 * machine.geometry.stroke, 6)
    variables = (
        *switches(),
        Variable("theta", "input", "rad", "measured angles", size=n, min=-reach, max=reach),
        Variable(
            "tau_meas",
            "input",
            "N m",
            "measured torques",
            n,
            holding_torque(machine),
            min=-1e4,
            max=1e4,
        ),
        Variable("theta_f", "output", "rad", "filtered angles", size=n),
        Variable("theta_fd", "output", "rad/s", "their rates", size=n),
        Variable("theta_fdd", "output", "rad/s2", "their accelerations", size=n),
        Variable("tau_f", "output", "N m", "filtered torques", size=n),
        Variable(
            "chi_f",
            "output",
            "1",
            "filtered actuator basis",
            len(chi),
            chi,
            elements=basis_names(machine),
        ),
    )
    return Interface(
        "filter",
        "Hann window, derivatives and filtered actuator basis [SH, IV-D]",
        machine.timing.feedforward,
        variables,
        {
            "N": n,
            "N_CHI": n * n_basis,
            "POINTS": machine.control.hann_points,
            "MAX_ALIGNMENT": MAX_ALIGNMENT,
            **Bank.compensated(machine).constants,
        },
    )

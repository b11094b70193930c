"""Variables and sample time of the estimator FMU (regressor E and Kalman filter K)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexhex.fmus.common.interface import Interface, Variable
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.model.effect_bank import Bank
from flexhex.fmus.common.model.geometry import Frames, coordinate_inputs
from flexhex.fmus.common.model.parameters import base_parameters, parameters
from flexhex.fmus.estimator.equations import row_width

MOST_VARIANCE = 1e-2
"""Largest first variance, normalised: a tenth of a parameter's size. A weak direction's deviation
is shared by parameters that are known well together, and without their correlation more than
this sets those free too (the first seconds get worse)."""


def normalisation(machine: Machine, p: NDArray[np.float64]) -> NDArray[np.float64]:
    """Scale of each parameter: |p|, but not below the parameter's floor.

    [SH, IV-G] normalises by an initial least-squares estimate; without the floor an
    estimate near zero would never move again.
    """
    floors = np.array([par.floor for par in parameters(machine)])
    scale: NDArray[np.float64] = np.maximum(np.abs(p), floors)
    return scale


def process_noise(machine: Machine) -> NDArray[np.float64]:
    """Diagonal of R1 (n_p,), normalised: 1e-5 for the end-effector, 1e-7 for the rest."""
    c = machine.control
    return np.array(
        [c.R1_end_effector if par.body == "end-effector" else c.R1 for par in parameters(machine)]
    )


def first_variance(
    machine: Machine, p: NDArray[np.float64], std: NDArray[np.float64] | None
) -> NDArray[np.float64]:
    """Normalised first variances (n_p,) of p that was fitted with the deviations std.

    (std / scale)^2, but no less than P0, since the machine has changed since the fit, and no
    more than MOST_VARIANCE. Without std: P0 for all.
    """
    least = np.full(len(p), machine.control.P0)
    if std is None:
        return least
    fitted = (std / normalisation(machine, p)) ** 2
    return np.asarray(np.clip(fitted, least, np.maximum(least, MOST_VARIANCE)))


def interface(machine: Machine) -> Interface:
    """Estimator of a machine: filtered motion, basis and torque in, parameters out."""
    n, x0, listed = machine.n_arms, Frames.of(machine).x0, parameters(machine)
    p0 = base_parameters(machine)
    named: dict[str, Any] = {
        "size": len(listed),
        "elements": tuple(par.name for par in listed),
        "units": tuple(par.unit for par in listed),
    }
    each: dict[str, Any] = {"size": len(listed), "elements": named["elements"]}
    n_effects = Bank.known(machine).n_gains
    n_chi = n * (1 + 2 * machine.actuator.n_harmonics) + n_effects
    # columns of effects have units of their own: nothing but nonsense is refused
    reach = 1e9 if n_effects else 2.0
    c = machine.control
    variables = (
        Variable("p0", "parameter", "1", "first estimate", start=p0, min=-1e4, max=1e4, **named),
        Variable(
            "scale",
            "parameter",
            "1",
            "normalisation of each parameter",
            start=normalisation(machine, p0),
            min=1e-12,
            max=1e4,
            **named,
        ),
        Variable(
            "adapt", "parameter", "1", "1: adapts, 0: stays at p0", start=1, min=0, max=1, **each
        ),
        Variable(
            "R1",
            "parameter",
            "1",
            "normalised drift variance an update",
            start=process_noise(machine),
            min=0,
            max=1,
            **each,
        ),
        Variable("R2", "parameter", "N2 m2", "torque variance", start=c.R2, min=1e-9, max=1e3),
        Variable(
            "P0",
            "parameter",
            "1",
            "first normalised variance of each parameter",
            start=c.P0,
            min=0,
            max=1e3,
            **each,
        ),
        Variable("t_start", "parameter", "s", "nothing adapts before", start=0.3, min=0, max=1e6),
        *coordinate_inputs(machine, "filtered x~"),
        Variable("chi_f", "input", "1", "filtered actuator basis", n_chi, min=-reach, max=reach),
        Variable("tau_f", "input", "N m", "filtered torque", size=n, min=-1e4, max=1e4),
        Variable(
            "p",
            "output",
            "1",
            "estimated parameters",
            start=p0,
            initial_from=("p0", "scale"),
            **named,
        ),
        Variable(
            "p_std",
            "output",
            "1",
            "their standard deviations",
            initial_from=("scale", "adapt", "P0"),
            **named,
        ),
        Variable("innovation", "output", "N m", "torque that p before the update missed", size=n),
    )
    return Interface(
        "estimator",
        "Kalman filter of the dynamic parameters [SH, IV-F, IV-G]",
        machine.timing.adaptation,
        variables,
        {"N": n, "N_X": len(x0), "N_P": len(listed), "WIDTH": row_width(machine)},
    )

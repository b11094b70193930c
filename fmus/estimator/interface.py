"""Variables and sample time of the estimator FMU (regressor E and Kalman filter K)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexhex.fmus.common.interface import Interface, Item, Variable, flag, parameter
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.model.effect_bank import Bank
from flexhex.fmus.common.model.geometry import Frames, coordinate_inputs
from flexhex.fmus.common.model.parameters import base_parameters, parameters
from flexhex.fmus.common.model.rest import basis_at_rest, basis_names, holding_torque
from flexhex.fmus.estimator.equations import row_width

INNOVATION = "innovation: measured torque minus its prediction with the estimate before the update"
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


def _settings(
    machine: Machine, p0: NDArray[np.float64], named: Mapping[str, Any]
) -> tuple[Variable, ...]:
    """Parameters of the FMU; named: size, names and units of p."""
    each = {key: named[key] for key in ("size", "elements")}
    c, scale, noise = machine.control, normalisation(machine, p0), process_noise(machine)
    drift = "normalised variance added at each update"
    return (
        parameter("p0", "1", "first estimate", p0, -1e4, 1e4, **named),
        parameter("scale", "1", "normalisation of each parameter", scale, 1e-12, 1e4, **named),
        flag("adapt", "parameter", "true: estimated, false: fixed at p0", 1, **each),
        parameter("R1", "1", drift, noise, 0, 1, **each),
        parameter("R2", "N2 m2", "variance of the measured torque", c.R2, 1e-9, 1e3),
        parameter("P0", "1", "first normalised variance of each parameter", c.P0, 0, 1e3, **each),
        parameter("t_start", "s", "time of the first update", 0.3, 0, 1e6),
    )


def interface(machine: Machine) -> Interface:
    """Estimator of a machine: filtered motion, basis and torque in, parameters out."""
    n, x0, listed = machine.n_arms, Frames.of(machine).x0, parameters(machine)
    p0 = base_parameters(machine)
    named: dict[str, Any] = {
        "size": len(listed),
        "elements": tuple(par.name for par in listed),
        "units": tuple(par.unit for par in listed),
    }

    def from_(*sources: str) -> dict[str, Any]:
        return {**named, "initial_from": sources}

    n_effects = Bank.compensated(machine).n_gains
    chi = basis_at_rest(machine)
    # columns of effects have units of their own, so their range is wide
    reach = 1e9 if n_effects else 2.0
    variables = (
        *_settings(machine, p0, named),
        *coordinate_inputs(machine, "filtered x~"),
        Variable(
            "chi_f",
            "input",
            "1",
            "filtered actuator basis",
            len(chi),
            chi,
            min=-reach,
            max=reach,
            elements=basis_names(machine),
        ),
        Variable(
            "tau_f",
            "input",
            "N m",
            "filtered torque",
            n,
            holding_torque(machine),
            min=-1e4,
            max=1e4,
        ),
        Variable("p", "output", "1", "estimated parameters", start=p0, **from_("p0", "scale")),
        Variable(
            "p_std", "output", "1", "their standard deviations", **from_("scale", "adapt", "P0")
        ),
        Variable("innovation", "output", "N m", INNOVATION, size=n),
    )
    return Interface(
        "estimator",
        "Kalman filter of the dynamic parameters [SH, IV-F, IV-G]",
        machine.timing.adaptation,
        variables,
        {"N": n, "N_X": len(x0), "N_P": len(listed), "WIDTH": row_width(machine)},
        (
            Item("not_finite", "regressor not finite, p unchanged"),
            Item("covariance", "covariance not positive definite, p unchanged"),
        ),
    )

"""The 162 parameters: estimates, standard deviations, trajectories, and the truth beside them.

Only this part of the report looks at the truth, after everything else is done. It stands as
start values in machine.fmu; neither the fit nor the control may ever read it. The machine has
112 mechanism values and its arms differ, so the truth is projected onto the 162 parameters by
`regrouped` (shared entries are means over the arms).

Two truths: the machine is cold when the data for the fit are taken and warm when it runs.
With the share s of its drift reached, motor torque tau acts as (1 - gain s) tau - drift s:

    p_warm = (p_cold + [drift s on every o]) / (1 - gain s)

Without a truth file the machine is its model, plant.fmu, which does not drift.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import casadi as ca
import numpy as np

from flexhex.diagnosis.estimation.identify import Fit
from flexhex.fmus.common.archive import read_bytes
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.model.bodies import Mechanism
from flexhex.fmus.common.model.effect_bank import Bank
from flexhex.fmus.common.model.parameters import (
    Parameter,
    actuator_parameters,
    parameters,
    regrouped,
    term,
)
from flexhex.fmus.estimator.interface import normalisation
from flexhex.output.progress import Progress
from flexhex.simulation.builder import Builder
from flexhex.simulation.cases import WARM, table_cases, whole_moves
from flexhex.simulation.runs import Array, record, samples, variant
from flexhex.ssp.fmu import read_fmu

SIGNALS = ("K.p", "K.p_std")


@dataclass(frozen=True)
class Estimates:
    """All parameters: fit and adapted estimate with deviations, truth when cold and warm (n_p,).

    t (m,) [s], p, p_std (m, n_p): trajectory of the adaptive run. scale (n_p,): size below
    which a parameter is taken for zero. loose: names the data do not determine.
    """

    listed: tuple[Parameter, ...]
    fit: Array
    std: Array
    cold: Array
    warm: Array
    scale: Array
    loose: tuple[str, ...]
    t: Array
    p: Array
    p_std: Array

    def within(self, deviations: float = 2.0) -> tuple[float, float]:
        """Share of the parameters whose truth lies within some standard deviations: of the fit
        (truth of the cold machine) and of the last adapted values (warm machine)."""
        fit = np.abs(self.fit - self.cold) < deviations * self.std
        last = np.abs(self.p[-1] - self.warm) < deviations * self.p_std[-1]
        return float(fit.mean()), float(last.mean())


def run(builder: Builder, fit: Fit, progress: Progress, command: str, quick: bool) -> Estimates:
    """One adaptive run, and the true values out of the simulated machine's FMU."""
    machine = builder.machine
    seconds = whole_moves(machine, 8.0) if quick else machine.reference.duration
    adaptive = table_cases(machine, fit.p, seconds, fit.std)[-1]
    case = variant(adaptive, "parameters", "all parameters adapt", adaptive.duration, {})
    (result,) = record(builder, [case], SIGNALS, command, progress)
    t, p, _ = samples(result, "K.p")
    p_std = samples(result, "K.p_std")[1]
    plant = "machine" if builder.has_truth else "plant"
    values = start_values(builder.out / "fmus" / f"{plant}.fmu")
    cold = projected(machine, values)
    warm = warmed(machine, cold, values, WARM + seconds / 2) if builder.has_truth else cold
    listed, scale = parameters(machine), normalisation(machine, fit.p)
    return Estimates(listed, fit.p, fit.std, cold, warm, scale, fit.undetermined, t, p, p_std)


def start_values(path: Path) -> dict[str, Array]:
    """Start values of an FMU's parameters by array name; scalars have one entry."""
    starts: dict[str, list[float]] = {}
    for variable in read_fmu(read_bytes(path), path.name).of("parameter"):
        if variable.start is not None:
            starts.setdefault(variable.array, []).append(variable.start)
    return {name: np.array(values) for name, values in starts.items()}


def projected(machine: Machine, values: Mapping[str, Array]) -> Array:
    """The cold machine's actuators, mechanism and effects as its parameters (n_p,)."""
    full = Mechanism.split(ca.DM(values["mechanism"]), machine.n_arms)
    effects = Bank.compensated(machine).values
    return np.concatenate([values["actuator"], regrouped(machine, full), effects])


def warmed(machine: Machine, cold: Array, values: Mapping[str, Array], age: float) -> Array:
    """The parameters that act like the machine `age` [s] after it was switched on (n_p,)."""
    time, gain = float(values["drift_time"][0]), float(values["drift_gain"][0])
    reached = 1 - float(np.exp(-age / time))
    offsets = [k for k, par in enumerate(actuator_parameters(machine)) if term(par.name) == "o"]
    warm = cold.copy()
    warm[offsets] += reached * values["drift_torque"]
    return np.asarray(warm / (1 - gain * reached))

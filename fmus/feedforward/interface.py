"""Variables and sample time of the feedforward FMU."""

from __future__ import annotations

from flexhex.fmus.common.interface import Interface, Item, Variable
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.model.effect_bank import Bank
from flexhex.fmus.common.model.geometry import Frames, coordinate_inputs
from flexhex.fmus.common.model.parameters import base_parameters, parameters


def interface(machine: Machine) -> Interface:
    """Feedforward of a machine: reference motion and parameters in, torque out."""
    n, x0, listed = machine.n_arms, Frames.of(machine).x0, parameters(machine)
    names = tuple(par.name for par in listed)
    units = tuple(par.unit for par in listed)
    variables = (
        *coordinate_inputs(machine, "reference x~"),
        Variable("z", "input", "1", "Dahl states", size=n, min=-1, max=1),
        Variable(
            "p",
            "input",
            "1",
            "parameters",
            size=len(listed),
            start=base_parameters(machine),
            min=-1e4,
            max=1e4,
            elements=names,
            units=units,
        ),
        Variable("tau_ff", "output", "N m", "feedforward torque", size=n),
    )
    return Interface(
        "feedforward",
        "Inverse dynamics of the reference motion [SH, Eq. (31)]",
        machine.timing.feedforward,
        variables,
        {"N": n, "N_X": len(x0), "N_P": len(listed), **Bank.compensated(machine).constants},
        (Item("not_finite", "torque not finite, the last finite torque is shown"),),
    )

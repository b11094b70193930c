"""Variables and sample time of the kinematics FMU (N_F and N_E in the loop)."""

from __future__ import annotations

from flexhex.fmus.common.interface import Interface, Item, Variable, count, flag, parameter
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.model.geometry import Frames, coordinates


def interface(machine: Machine) -> Interface:
    """Kinematics of a machine: actuator angles in, x~ with rates and Dahl states out."""
    n, x0 = machine.n_arms, Frames.of(machine).x0
    reach = round(1.15 * machine.geometry.stroke, 6)
    variables = (
        count("corrections", "Newton corrections per tick; [SH] uses one", 1, 1, 10),
        parameter(
            "tolerance",
            "1",
            "largest |D| that counts as converged (m and 1 mixed, as the rows of D are)",
            1e-6,
            1e-14,
            1e-2,
        ),
        Variable("theta", "input", "rad", "actuator angles", size=n, min=-reach, max=reach),
        Variable("thetad", "input", "rad/s", "their rates", size=n, min=-1e3, max=1e3),
        Variable("thetadd", "input", "rad/s2", "their accelerations", size=n, min=-1e6, max=1e6),
        Variable("x", "output", "1", "coordinates x~", len(x0), x0, **coordinates(machine)),
        Variable("xd", "output", "1/s", "rates of x~", size=len(x0), **coordinates(machine, "/s")),
        Variable(
            "xdd",
            "output",
            "1/s2",
            "accelerations of x~",
            size=len(x0),
            **coordinates(machine, "/s2"),
        ),
        Variable("z", "output", "1", "Dahl states", size=n, min=-1, max=1),
        Variable("residual", "output", "1", "|D| after the corrections", min=0),
        flag("converged", "output", "residual within tolerance", 1),
    )
    return Interface(
        "kinematics",
        "Newton-Raphson kinematics of the hexapod [SH, IV-E]",
        machine.timing.feedforward,
        variables,
        {"N": n, "N_X": len(x0), "N_D": len(x0) - n},
        (Item("out_of_reach", "pose out of reach, the last good pose is shown"),),
    )

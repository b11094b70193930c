"""Variables and sample time of the pose FMU, the inverse kinematics."""

from __future__ import annotations

from flexhex.fmus.common.interface import Interface, Item, Variable, flag, parameter
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.model.geometry import pose_variables

MARGIN = 0.01
"""Least angle [rad] between an upper arm and its dead point: there a motor has to turn a hundred
times as far as E moves."""


def interface(machine: Machine) -> Interface:
    """Wanted pose of E in, reference angles out; MachineError without a platform."""
    n, stroke = machine.n_arms, machine.geometry.stroke
    variables = (
        parameter("stroke", "rad", "largest |r| of each joint", stroke, 0.01, 1.5),
        parameter("margin", "rad", "least angle to the dead point of an arm", MARGIN, 1e-4, 1.0),
        *pose_variables(machine, "input"),
        Variable("r", "output", "rad", "reference angles", size=n),
        Variable("rd", "output", "rad/s", "their rates", size=n),
        Variable("rdd", "output", "rad/s2", "their accelerations", size=n),
        flag("reachable", "output", "the arm reaches the pose", 1, size=n),
    )
    return Interface(
        "pose",
        "Inverse kinematics of the hexapod: a wanted pose of the end-effector to reference angles",
        machine.timing.base,
        variables,
        {"N": n},
        (Item("out_of_reach", "pose out of reach, the angles of the last one within are shown"),),
    )

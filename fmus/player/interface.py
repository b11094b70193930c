"""Variables and sample time of the player FMU, a reference that plays a trajectory file."""

from __future__ import annotations

from flexhex.fmus.common.interface import Interface, Variable, parameter
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.model.geometry import pose_variables
from flexhex.fmus.player.table import Kind, channels

MAX_PAYLOAD = 50.0
"""Largest payload [kg]."""


def interface(machine: Machine, kind: Kind) -> Interface:
    """Nothing in; out come the angles of the table, or the poses, and the payload."""
    n = machine.n_arms
    joints = (
        Variable("r", "output", "rad", "reference angles", size=n),
        Variable("rd", "output", "rad/s", "their rates", size=n),
        Variable("rdd", "output", "rad/s2", "their accelerations", size=n),
    )
    variables = (
        parameter("t_start", "s", "rest at the first row before the motion", 2, 0, 1e4),
        *(joints if kind == "joints" else pose_variables(machine, "output")),
        Variable("payload", "output", "kg", "mass at the end-effector", min=0, max=MAX_PAYLOAD),
    )
    what = "reference angles" if kind == "joints" else "wanted poses of the end-effector"
    return Interface(
        "player",
        f"Player of a trajectory file: {what}, payload",
        machine.timing.base,
        variables,
        {"N_MOTION": 3 * channels(machine, kind)},
    )

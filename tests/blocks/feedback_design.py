"""The feedback's loop by python-control: sampled plant and controller, other machines."""

from __future__ import annotations

from functools import cache
from typing import Any

import control
import numpy as np

from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.feedback.design import Gains, design
from tests.blocks.loaded import machine

TS = 0.00025


@cache
def gains() -> Gains:
    return design(machine())


def discrete_plant(m: Machine, inertia: float) -> Any:
    """Torque command to the angle that the controller sees, sampled by python-control."""
    a = 2 * np.pi * m.drive.f_current
    A = np.array([[0, 1, 0], [0, 0, 1 / inertia], [0, 0, -a]])
    drive = control.ss(A, np.array([[0], [0], [a]]), np.array([[1, 0, 0]]), 0)
    sampled = control.sample_system(drive, m.timing.base, method="zoh")
    # one step until the command is shown (results appear a sample time later), and the drive's
    steps = 1 + round((m.drive.t_command + m.drive.t_measurement) / m.timing.base)
    delay = control.tf([1], [1, *[0] * steps], m.timing.base)
    return control.series(control.ss(delay), sampled)


def discrete_controller(m: Machine, g: Gains) -> Any:
    """The PID made discrete by python-control."""
    s = control.tf("s")
    pid = g.kp * (1 + 1 / (g.t_i * s) + g.t_d * s / (g.t_f * s + 1))
    return control.ss(control.sample_system(pid, m.timing.base, method="tustin"))


def altered(section: str, **values: Any) -> Machine:
    changed = getattr(machine(), section).model_copy(update=values)
    return machine().model_copy(update={section: changed})

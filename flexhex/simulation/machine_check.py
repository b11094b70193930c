"""Whether the FMUs of a machine can be made: everything but the compiling is done once.

A machine file that reads well can still ask for what a room refuses: a start value beyond its
range, a feedback that no lead filter gives, sample times that do not meet. `Builder.check` makes
all interfaces with the feedback's design and the schedule; here its complaints get their field.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from flexhex.fmus.common.errors import FlexhexError, MachineError, StartValueError
from flexhex.fmus.common.interface import Interface

Made = TypeVar("Made")
FIELDS = {
    "Ts": "timing",
    "R1": "control.R1",
    "R2": "control.R2",
    "P0": "control.P0",
    "actuator": "actuator",
    "alignment": "timing.feedforward",
    "amplitude": "reference.amplitude",
    "command_delay": "drive.t_command",
    "duration": "reference.duration",
    "effect": "effects",
    "f_current": "drive.f_current",
    "kp": "control",
    "measurement_delay": "drive.t_measurement",
    "mechanism": "bodies, flexures",
    "move": "reference.move",
    "p": "actuator, bodies, flexures",
    "p0": "actuator, bodies, flexures",
    "period": "reference.period",
    "reference_delay": "timing.feedforward, drive",
    "scale": "actuator, bodies, flexures",
    "stroke": "geometry.stroke",
    "t_d": "control",
    "t_f": "control",
    "t_i": "control",
    "tau_max": "drive.K_t, drive.I_peak",
    "tau_step": "drive.K_t, drive.I_step",
    "theta_step": "encoder.step",
    "x": "geometry.x_E0",
}
"""FMU variable -> the field of the machine file that its start value comes from."""


def named(path: Path, make: Callable[[], Made], where: str = "") -> Made:
    """What `make` returns; its complaint as a MachineError with file, field, FMU (`where`)."""
    try:
        made = make()
        if isinstance(made, Interface):
            made.parameters  # noqa: B018 - Ts is added, and checked, only here
        return made
    except FlexhexError as error:
        text = str(error)
        if text.startswith(str(path)):
            raise
        if isinstance(error, StartValueError):
            text = f"{FIELDS.get(error.variable, 'machine')}: in {where}.fmu {text}"
        elif not isinstance(error, MachineError):
            text = f"timing: {text}"
        raise MachineError(f"{path}: {text}") from None

"""Which keys of a machine file a start value of an FMU comes from, with the values they have."""

from __future__ import annotations

import re
from typing import Any

from flexhex.fmus.common.errors import StartValueError
from flexhex.fmus.common.interface import array_of
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.model.parameters import ACTUATOR

DESIGN = tuple(
    f"control.{key}" for key in ("f_crossover", "phase_margin", "integrator_ratio", "J_design")
)
KEYS: dict[str, tuple[str, ...]] = {
    "R1": ("control.R1", "control.R1_end_effector"),
    "R2": ("control.R2",),
    "P0": ("control.P0",),
    "alignment": ("timing.feedforward", "timing.adaptation"),
    "amplitude": ("reference.amplitude",),
    "command_delay": ("drive.t_command", "timing.base"),
    "duration": ("reference.duration",),
    "f_current": ("drive.f_current",),
    "kp": DESIGN,
    "measurement_delay": ("drive.t_measurement", "timing.base"),
    "move": ("reference.move",),
    "period": ("reference.period",),
    "reference_delay": ("timing.feedforward", "drive.t_command", "drive.t_measurement"),
    "stroke": ("geometry.stroke",),
    "t_d": DESIGN,
    "t_f": DESIGN,
    "t_i": DESIGN,
    "tau_max": ("drive.K_t", "drive.I_peak"),
    "tau_step": ("drive.K_t", "drive.I_step"),
    "theta_step": ("encoder.step",),
}
"""FMU variable -> the keys that its start value is computed from."""
BODIES = {"upper": "bodies.upper", "lower": "bodies.lower", "end_effector": "bodies.end_effector"}
STIFFNESS = {
    "k_u2": "flexures.k_u[1]",
    "k_u3": "flexures.k_u[2]",
    "k_s1": "flexures.k_s[1]",
    "k_s2": "flexures.k_s[2]",
}


_TERM = re.compile(rf"\b{ACTUATOR}\[(\d+)\]\.([okdcab])(?:\[(\d+)\])?$")
_PART = re.compile(rf"\b({'|'.join((*BODIES, 'flexure'))})(?:\[\d+\])?\.(\w+)(?:\[\d+\])?$")


def refused(machine: Machine, error: StartValueError, block: str) -> str:
    """`bodies.lower.m = 2200 kg: must be -100 to 100 kg (...)`: keys, values, range and remedy."""
    keys = keys_of(error, block)
    low, high = (f"{limit:.9g}" for limit in error.limits)
    unit = f" {error.unit}".removesuffix(" 1")
    intermediate = "" if len(keys) == 1 else f"{error.name} is {error.value:.9g}{unit}, "
    remedy = "the value, was it meant in another unit?" if len(keys) == 1 else "one of them"
    return (
        f"{', '.join(shown(machine, key) for key in keys) or 'machine'}: {intermediate}"
        f"must be {low} to {high}{unit}"
        f" (range{'' if intermediate else f' of {error.name}'} in {block}.fmu):"
        f" correct {remedy}"
    )


def keys_of(error: StartValueError, block: str) -> tuple[str, ...]:
    """Keys of the machine file that a start value is computed from; none where none is known.

    An entry of a list is `actuator.o[2]`, counted from 1.
    """
    variable = array_of(error.name)
    if variable == "Ts":
        base = dict.fromkeys(("plant", "feedback", "reference", "pose"), "base")
        return (f"timing.{(base | {'estimator': 'adaptation'}).get(block, 'feedforward')}",)
    if variable in KEYS:
        return KEYS[variable]
    if term := _TERM.search(error.name):
        arm, quantity, harmonic = term.groups()
        return (f"actuator.{quantity}[{arm}{f',{harmonic}' if harmonic else ''}]",)
    part = _PART.search(error.name)
    if not part:
        return ("effects",) if "." in error.name else ()
    owner, quantity = part.groups()
    if owner == "flexure":
        return (STIFFNESS[quantity],)
    keys = [f"{BODIES[owner]}.m"]
    if quantity != "m":
        keys.append(f"{BODIES[owner]}.c")
    if quantity.startswith("J"):
        keys.append(f"{BODIES[owner]}.Ic")
    if owner == "upper" and quantity == "J":
        keys.append(f"{BODIES[owner]}.J_rotor")
    return tuple(keys)


def shown(machine: Machine, key: str) -> str:
    """`bodies.upper.c = [0.13, 0, -0.004] m`; the key alone where it is no quantity."""
    value: Any = machine
    unit = ""
    name, _, entry = key.partition("[")
    for part in name.split("."):
        field = type(value).model_fields[part]
        unit = next((m.unit for m in field.metadata if hasattr(m, "unit")), "")
        value = getattr(value, part)
    for number in re.findall(r"\d+", entry):
        value = value[int(number) - 1]
    if not isinstance(value, int | float) and not unit:
        return key
    listed = value if isinstance(value, tuple) else (value,)
    text = ", ".join(f"{number:.6g}" for number in listed)
    return f"{key} = {f'[{text}]' if isinstance(value, tuple) else text} {unit}".removesuffix(" 1")

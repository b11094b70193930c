"""A machine file for a hexapod of one's own: three pairs of arms, given by seven lengths."""

from __future__ import annotations

import math
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from flexhex.arguments import SHIPPED
from flexhex.compare.runs import Run
from flexhex.diagnosis.machine_files.toml_text import toml_text
from flexhex.fmus.common.errors import MachineError
from flexhex.fmus.common.machine.complaints import complaints
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.model.geometry import Frames
from flexhex.ssp.result import Array, Group, Result
from flexhex.view.data import page_data
from flexhex.view.page import write_view

TEMPLATE = SHIPPED / "tflex.toml"
"""Where all that is no geometry comes from, to be replaced by the user."""
PAIRS = 3
DIGITS = 9
"""Decimals of a length [m] or a direction."""
HEAD = (
    "A hexapod of three pairs of arms, written by `flexhex init`. The geometry is yours; l and the",
    "platform's points follow from it. All else is the T-Flex's and stands here as a start:",
    "replace what you know (masses, flexures, motors, encoders) and say where it comes from.",
)
SHOWN = 2.0
"""Time in which the drawing moves one joint [s]."""


@dataclass(frozen=True)
class Hexapod:
    """radius, spacing: of a pair's motors from the centre and from each other [m]; the same of the
    platform's joints, whose pairs stand between those of the motors; upper: length of the upper
    arms [m]; lift: their angle above the horizontal at neutral [rad]; height: of the end-effector's
    origin over the motor axes [m]."""

    radius: float
    spacing: float
    platform_radius: float
    platform_spacing: float
    upper: float
    lift: float
    height: float

    def arms(self) -> list[dict[str, Array]]:
        """x_B, axis, u_B, r_EP of the six arms, in the order of the T-Flex."""
        arms = []
        for k in range(2 * PAIRS):
            pair, side = divmod(k, 2)
            out, along = _directions(2 * math.pi * pair / PAIRS)
            sign = -1.0 if side == 0 else 1.0
            # an arm reaches for the platform's pair on its own side, half a pair's angle away
            towards, across = _directions(2 * math.pi * (pair + 0.5 * sign) / PAIRS)
            up = np.array([0.0, 0.0, 1.0])
            arms.append(
                {
                    "x_B": self.radius * out + sign * self.spacing / 2 * along,
                    "axis": -along,
                    "u_B": math.cos(self.lift) * out + math.sin(self.lift) * up,
                    "r_EP": self.platform_radius * towards
                    - sign * self.platform_spacing / 2 * across,
                }
            )
        return arms

    def lower(self) -> float:
        """Length l of the lower arms [m]: what closes the loops at neutral, alike for all arms."""
        first = self.arms()[0]
        knee = first["x_B"] + self.upper * first["u_B"]
        joint = np.array([0.0, 0.0, self.height]) + first["r_EP"]
        return float(np.linalg.norm(joint - knee))


def _directions(angle: float) -> tuple[Array, Array]:
    """Outwards and along the circle (3,) at an angle about z [rad]."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array([c, s, 0.0]), np.array([-s, c, 0.0])


def machine_text(hexapod: Hexapod, file: Path) -> tuple[str, Machine]:
    """The machine file and what it says; MachineError where it is no machine."""
    data = tomllib.loads(TEMPLATE.read_text(encoding="utf-8"))
    before = {name: data["geometry"][name]["value"] for name in ("L", "l")}
    data["name"] = "".join(c if c.isascii() and c.isalnum() else "_" for c in file.stem.lower())
    geometry, lower = data["geometry"], hexapod.lower()
    geometry["L"] = _given(hexapod.upper, "m")
    geometry["l"] = _derived(lower, "m", "closes the loops at the neutral pose")
    geometry["x_E0"] = _given([0.0, 0.0, hexapod.height], "m")
    for name, factor in (("upper", hexapod.upper / before["L"]), ("lower", lower / before["l"])):
        centre = data["bodies"][name]["c"]
        centre["value"] = [round(factor * centre["value"][0], DIGITS), *centre["value"][1:]]
    arms = [
        {
            name: _given([round(float(v), DIGITS) + 0.0 for v in value], "m")
            if name in ("x_B", "r_EP")
            else _given([round(float(v), 12) + 0.0 for v in value], "1")
            for name, value in arm.items()
        }
        for arm in hexapod.arms()
    ]
    data["arms"] = arms
    try:
        machine = Machine.model_validate(data)
    except ValidationError as error:
        raise MachineError("\n".join(complaints(file, Machine, error.errors()))) from None
    Frames.of(machine, where=str(file))
    del data["arms"]
    return toml_text(data, {"arms": arms}, HEAD), machine


def _given(value: Any, unit: str) -> dict[str, Any]:
    return {"value": value, "unit": unit, "source": "assumed", "note": "given to flexhex init"}


def _derived(value: float, unit: str, note: str) -> dict[str, Any]:
    return {"value": value, "unit": unit, "source": "derived", "note": note}


def draw(machine: Machine, path: Path) -> Path:
    """A page with the machine in 3D, each joint going once to its amplitude and back."""
    ts, n = 0.02, machine.n_arms
    t = ts * np.arange(round(n * SHOWN / ts))
    theta = np.zeros((len(t), n))
    for i in range(n):
        mine = (t >= i * SHOWN) & (t < (i + 1) * SHOWN)
        theta[mine, i] = machine.reference.amplitude * np.sin(2 * np.pi * t[mine] / SHOWN)
    group = Group(1, ts, {"theta": theta}, {"theta": "rad"})
    run = Run("each joint in turn", str(path), "#1f6fb2", Result({"drawn": group}))
    data = page_data([run], machine, (0.0, float(t[-1])))
    return write_view(path, machine.name, data)

"""A machine is data: `machines/*.toml`, read and checked here.

`load_machine("machines/tflex.toml")` gives a frozen `Machine`. What the file says
about units and ranges is checked field by field; that bodies are physical and that
the mechanism closes is checked at the end. Every complaint is a MachineError that
names file, field and remedy.
"""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, ValidationError, model_validator

from fmus.common.errors import MachineError
from fmus.common.sections import (
    Actuator,
    Arm,
    Bodies,
    Body,
    Control,
    Drive,
    Encoder,
    EndEffector,
    Flexures,
    Geometry,
    Gravity,
    Matrix,
    Reference,
    Section,
    Timing,
    Vector,
)


@dataclass(frozen=True)
class Platform:
    """Lower arms and end-effector: l [m], x_E0 (3,) [m], r_EP (n_arms, 3) [m], bodies, flexures."""

    l: float  # noqa: E741 - the paper's neighbour of L
    x_E0: Vector
    r_EP: Matrix
    lower: Body
    end_effector: EndEffector
    flexures: Flexures


class Machine(Section):
    """Everything that is known about one machine, in SI units."""

    name: Annotated[str, Field(pattern=r"^[a-z][a-z0-9_-]*$")]
    gravity: Gravity
    geometry: Geometry
    arms: Annotated[tuple[Arm, ...], Field(min_length=6, max_length=6)]
    bodies: Bodies
    flexures: Flexures | None = None
    actuator: Actuator
    drive: Drive
    encoder: Encoder
    timing: Timing
    control: Control
    reference: Reference

    @property
    def n_arms(self) -> int:
        """Number of arms and actuators."""
        return len(self.arms)

    @property
    def has_platform(self) -> bool:
        """False for the actuators alone: upper arms without Q_i and E."""
        return self.flexures is not None

    @property
    def platform(self) -> Platform:
        """What stands on the upper arms. MachineError when the machine has none."""
        g, b, f = self.geometry, self.bodies, self.flexures
        r_EP = tuple(arm.r_EP for arm in self.arms if arm.r_EP is not None)
        if not (g.l and g.x_E0 and b.lower and b.end_effector and f and len(r_EP) == self.n_arms):
            raise MachineError(f"{self.name} has no platform, only its actuators")
        return Platform(g.l, g.x_E0, r_EP, b.lower, b.end_effector, f)

    @model_validator(mode="after")
    def _whole_platform(self) -> Machine:
        parts = {
            "geometry.l": self.geometry.l,
            "geometry.x_E0": self.geometry.x_E0,
            "bodies.lower": self.bodies.lower,
            "bodies.end_effector": self.bodies.end_effector,
            "flexures": self.flexures,
            **{f"arms.{i}.r_EP": arm.r_EP for i, arm in enumerate(self.arms, start=1)},
        }
        missing = [name for name, part in parts.items() if part is None]
        if missing and len(missing) < len(parts):
            raise ValueError(
                f"{missing[0]} is missing: give all of the platform, or nothing of it"
                " for the actuators alone"
            )
        return self

    @model_validator(mode="after")
    def _drive_delays(self) -> Machine:
        for name in ("t_command", "t_measurement"):
            steps = getattr(self.drive, name) / self.timing.base
            if abs(steps - round(steps)) > 1e-9:
                raise ValueError(f"drive.{name} is {steps:.6g} base steps, must be a whole number")
        return self

    @model_validator(mode="after")
    def _actuators(self) -> Machine:
        n, harmonics = self.n_arms, self.actuator.n_harmonics
        for name in ("o", "k", "d", "c", "a", "b"):
            rows = getattr(self.actuator, name)
            if len(rows) != n:
                raise ValueError(f"actuator.{name} has {len(rows)} entries for {n} arms")
        for name in ("a", "b"):
            for i, row in enumerate(getattr(self.actuator, name), start=1):
                if len(row) != harmonics:
                    raise ValueError(f"actuator.{name}, row {i}: {len(row)} of {harmonics} values")
        return self


def load_machine(path: str | Path) -> Machine:
    """Read and check a machine file.

    Raises MachineError when the file is missing, is no TOML, lacks a field or has an
    unknown one, holds a wrong unit or an impossible value, or when the mechanism
    does not close at the neutral pose.
    """
    from fmus.common.geometry import Frames

    try:
        machine = Machine.model_validate(machine_data(Path(path)))
    except ValidationError as error:
        raise MachineError("\n".join(complaint(path, e) for e in error.errors())) from None
    Frames.of(machine, where=str(path))
    return machine


def machine_data(path: Path) -> dict[str, Any]:
    """Plain data of a machine file, `extends` and `without_platform` carried out.

    extends = "tflex.toml"      everything from there; top-level keys here replace theirs
    without_platform = true     no lower arms, no end-effector, no flexures
    """
    data = read_toml(path)
    base = data.pop("extends", None)
    if base is not None:
        data = machine_data(path.with_name(str(base))) | data
    if data.pop("without_platform", False):
        data.pop("flexures", None)
        for section, keys in (("geometry", ("l", "x_E0")), ("bodies", ("lower", "end_effector"))):
            data[section] = {k: v for k, v in data.get(section, {}).items() if k not in keys}
        data["arms"] = [
            {k: v for k, v in arm.items() if k != "r_EP"} for arm in data.get("arms", [])
        ]
    return data


def truth_file(path: Path) -> Path:
    """The truth that belongs to a machine file: `tflex.toml` -> `tflex-truth.toml`.

    A file that extends another is another build of the same machine and shares its truth.
    """
    base = read_toml(path).get("extends")
    if base is not None:
        return truth_file(path.with_name(str(base)))
    return path.with_name(f"{path.stem}-truth.toml")


def read_toml(path: str | Path) -> dict[str, Any]:
    """Plain data of a TOML file; MachineError when it is missing or no TOML."""
    try:
        return tomllib.loads(Path(path).read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "not a UTF-8 text"
        raise MachineError(f"{path}: cannot be read ({reason})") from None
    except tomllib.TOMLDecodeError as error:
        raise MachineError(f"{path}: not valid TOML: {error}") from None


def complaint(path: str | Path, error: Any) -> str:
    """One line for one of pydantic's errors: file, field, what is wrong."""
    where = ".".join(str(part + 1 if isinstance(part, int) else part) for part in error["loc"])
    text = error["msg"].removeprefix("Value error, ")
    if error["type"] == "missing":
        text = "is missing"
    elif error["type"] == "extra_forbidden":
        text = "is not a known key: correct its spelling or take it out"
    return f"{path}: {where + ': ' if where else ''}{text}"

"""A small TOML file beside a robot's file, with what URDF, MJCF and SDF cannot say: joints of the
logs, gravity, rotors, a tool, how well all of it is known."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, PrivateAttr, ValidationError, model_validator

from flexhex.diagnosis.basemodels.tolerances import RobotTolerance
from flexhex.fmus.common.errors import MachineError
from flexhex.fmus.common.inertia import inertia_rows
from flexhex.fmus.common.machine.complaints import complaints
from flexhex.fmus.common.machine.quantity import quantity
from flexhex.fmus.common.machine.sections import Section, Vector
from flexhex.fmus.common.machine_file import read_toml

Array = NDArray[np.float64]
ENDING = ".toml"
HEAVIEST = 100.0
"""Gravity [m/s2] that no robot stands in: another unit."""


class Rotor(Section):
    """A joint's rotor: inertia about its own axis [kg m2], gear: its turns for one of the joint,
    [rad/m] of a joint that slides; tolerance: one standard deviation, relative.

    Without an inertia it is the file's, which MJCF alone has (`armature`); without a tolerance it
    is as well known as the file's inertias.
    """

    inertia: Annotated[float | None, quantity("kg m2", ge=0, bare=True)] = None
    gear: Annotated[float, quantity("1", gt=0, bare=True)] = 1.0
    tolerance: Annotated[float | None, quantity("1", ge=0, le=10, bare=True)] = None

    @model_validator(mode="after")
    def _whole(self) -> Rotor:
        if self.inertia is None and ("gear" in self.model_fields_set or self.tolerance is None):
            raise ValueError("inertia is missing: add inertia = ... [kg m2]")
        return self


class Tool(Section):
    """A body fixed to a link: mass [kg], centre (3,) [m] in the link's frame, inertia (6,) [kg m2]
    about it: xx, yy, zz, xy, xz, yz."""

    link: str
    mass: Annotated[float, quantity("kg", ge=0, bare=True)]
    centre: Annotated[Vector, quantity("m", 3, bare=True)]
    inertia: Annotated[Vector, quantity("kg m2", 6, bare=True)] = (0.0,) * 6

    @model_validator(mode="after")
    def _physical(self) -> Tool:
        least, middle, most = np.linalg.eigvalsh(inertia_rows(self.inertia))
        rounded = 1e-6 * max(most, 0.0)
        if least < -rounded:
            raise ValueError(f"inertia has a negative principal moment, {least:.3g} kg m2")
        if most > least + middle + rounded:
            raise ValueError(
                f"no body has the principal moments {least:.3g}, {middle:.3g}, {most:.3g} kg m2 of"
                " inertia, as the largest is more than the sum of the others"
            )
        if most > 0 and not self.mass:
            raise ValueError("inertia without a mass: add the mass, or take inertia out")
        return self


@dataclass(frozen=True)
class Load:
    """What carries payloads: the axis of the body, and ten parameters about its joint: of a mass of
    1 kg at the tool's centre, and of the tool itself."""

    axis: int
    unit: Array
    tool: Array


class More(Section):
    """What a TOML file says beside the robot's file; see docs/own-base.md. gravity (3,) [m/s2]: in
    the frame of the foot. effects: entries that `robot_effects` reads."""

    robot: Annotated[str, Field(min_length=1)]
    joints: tuple[str, ...] = ()
    gravity: Annotated[Vector | None, quantity("m/s2", 3, bare=True)] = None
    tolerance: RobotTolerance = RobotTolerance()
    rotor: dict[str, Rotor] = Field(default_factory=dict)
    tool: Tool | None = None
    effects: tuple[dict[str, Any], ...] = ()
    _said_by: Path = PrivateAttr(default=Path())

    @model_validator(mode="after")
    def _on_a_planet(self) -> More:
        if self.gravity is not None and np.linalg.norm(self.gravity) > HEAVIEST:
            raise ValueError(
                f"gravity is {np.linalg.norm(self.gravity):.4g} m/s2: on the earth it is 9.81"
            )
        return self

    @property
    def file(self) -> Path:
        """The robot's file; its path counts from the TOML's folder."""
        return self.folder / self.robot

    @property
    def folder(self) -> Path:
        """Where the TOML is."""
        return self._said_by.parent

    def where(self, key: str) -> str:
        """What an error about a key begins with."""
        return f"{self._said_by}: {key}"

    def refuse_strange(self, joints: Iterable[str]) -> None:
        """MachineError for the rotor of a joint that does not move or does not exist."""
        known = list(joints)
        for name in self.rotor:
            if name not in known:
                raise MachineError(
                    f"{self.where(f'rotor.{name}')}: no such joint moves in {self.file}"
                    f"{meant(name, known)}"
                )

    def rotor_of(self, joint: str, armature: float, usual: float) -> tuple[float, float]:
        """Inertia [kg m2, kg] of a joint's rotor behind its gear and its standard deviation,
        infinite where nothing is known.

        armature: of the robot's file, or 0; usual: its relative deviation. MachineError for a
        tolerance of nothing.
        """
        said = self.rotor.get(joint)
        if said is None:
            return (armature, usual * armature) if armature else (0.0, np.inf)
        if said.inertia is None and not armature:
            raise MachineError(
                f"{self.where(f'rotor.{joint}')}: inertia is missing, and {self.file} has no"
                " armature of this joint: add inertia = ... [kg m2]"
            )
        value = armature if said.inertia is None else said.inertia * said.gear**2
        return value, value * (usual if said.tolerance is None else said.tolerance)

    def attach(self, pin: Any, model: Any, places: Sequence[int]) -> Load | None:
        """Put the tool on the body that carries it; places: numbers in the model of the axes.

        MachineError for a link that there is not, or that stands still.
        """
        tool = self.tool
        if tool is None:
            return None
        kinds = pin.FrameType.BODY, pin.FrameType.OP_FRAME
        frames = {frame.name: frame for frame in model.frames if frame.type in kinds}
        if tool.link not in frames:
            raise MachineError(
                f"{self.where('tool.link')}: there is no link {tool.link} in {self.file}"
                f"{meant(tool.link, [name for name in frames if name != 'universe'])}"
            )
        place, at = frames[tool.link].parentJoint, frames[tool.link].placement
        if not place:
            raise MachineError(
                f"{self.where('tool.link')}: {tool.link} moves with none of the axes: name a link"
                " that does, or take [tool] out"
            )
        centre, J = np.array(tool.centre), np.array(inertia_rows(tool.inertia))
        unit, body = (
            at.act(pin.Inertia(*own))
            for own in ((1.0, centre, np.zeros((3, 3))), (tool.mass, centre, J))
        )
        if tool.mass:
            model.inertias[place] += body
        return Load(places.index(place), unit.toDynamicParameters(), body.toDynamicParameters())


def is_more(name: str | Path) -> bool:
    """Whether `--base` names such a file."""
    return Path(name).suffix == ENDING


def read_more(name: str | Path) -> More:
    """What `--base` says of a robot beside its file; nothing more where it names that itself.

    MachineError for a TOML file that cannot be read, or has wrong keys, types, units, values.
    """
    path = Path(name)
    if not is_more(path):
        return More(robot=str(path))
    data = read_toml(path)
    if "robot" not in data and "geometry" in data:
        raise MachineError(f"{path}: the machine file of a hexapod: give it as --machine {path}")
    try:
        more = More.model_validate(data)
    except ValidationError as error:
        raise MachineError("\n".join(complaints(path, More, error.errors()))) from None
    more._said_by = path
    if is_more(more.file):
        raise MachineError(f"{more.where('robot')}: {more.robot} is no robot's file: name it")
    return more


def tolerance_of(name: str) -> Mapping[str, float]:
    """Tolerances that a TOML file of a robot gives, by their keys; none of any other base."""
    if not is_more(name):
        return {}
    known = read_more(name).tolerance
    return {key: getattr(known, key) for key in known.model_fields_set}


def meant(name: str, listed: Iterable[str]) -> str:
    """What a name that there is not may have been."""
    known = list(listed)
    close = get_close_matches(name, known, 1, 0.5)
    return f": is it {close[0]}?" if close else f": there are {', '.join(known)}"

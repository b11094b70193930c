"""A robot's file read by Pinocchio: URDF, MJCF or SDF, a fixed base, joints that turn or slide."""

from __future__ import annotations

import importlib
import os
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from flexhex.diagnosis.basemodels.robot_joints import (
    OPTION,
    chosen_joints,
    kind_of,
    moving_joints,
    refuse_couplings,
    refuse_mimics,
    refuse_other_order,
)
from flexhex.diagnosis.basemodels.robot_more import ENDING, Load, More, is_more, read_more
from flexhex.diagnosis.basemodels.robot_sdf import as_urdf
from flexhex.diagnosis.basemodels.robot_senseless import (
    odd_moments,
    refuse_negative,
    refuse_no_axis,
    refuse_odd_friction,
)
from flexhex.diagnosis.kinds import Kinds
from flexhex.fmus.common.errors import MachineError, UsageError, unreadable

ROOTS = {".urdf": "robot", ".xml": "mujoco", ".sdf": "sdf"}
"""What a file of each ending begins with."""
SHORT_OF = 1e-6
"""Share of its largest by which the smallest moment of a body may be negative: rounding."""


@dataclass(frozen=True)
class Robot:
    """model: Pinocchio's, with the chosen joints alone. joints: names in the order of the axes;
    places: their numbers in the model; kinds: of the axes; bodies: a link that each moves. remarks:
    what a user must know of the file. more: what stands beside it. load: its tool."""

    model: Any
    joints: tuple[str, ...]
    places: tuple[int, ...]
    kinds: Kinds
    bodies: tuple[str, ...]
    remarks: tuple[str, ...]
    more: More
    load: Load | None = None


def is_robot(name: str) -> bool:
    """Whether `--base` names such a file."""
    return Path(name).suffix in (*ROOTS, ".xacro", ENDING)


def refuse_robot(file: Path) -> None:
    """UsageError for a file that is not there, or of a kind that cannot be read; MachineError for
    what a TOML beside it says wrong."""
    if is_more(file) and file.is_file():
        more = read_more(file)
        if not is_robot(more.robot) or not more.file.is_file():
            what = "no such file" if is_robot(more.robot) else "no robot's file (.urdf, .xml, .sdf)"
            raise MachineError(f"{more.where('robot')}: {more.file}: {what}")
        file = more.file
    if not file.is_file():
        raise UsageError(f"--base {file}: {'is a folder' if file.is_dir() else 'no such file'}")
    if file.suffix == ".xacro":
        raise UsageError(f"--base {file}: a template: run `xacro {file} > robot.urdf` first")


def pinocchio(file: Path | str = "robot.urdf") -> Any:
    """The module. UsageError where it is not installed."""
    try:
        return importlib.import_module("pinocchio")
    except ImportError:
        raise UsageError(f"--base {file}: needs Pinocchio: pip install 'flexhex[robots]'") from None


def read_robot(
    file: Path,
    joints: Sequence[str],
    axes: int,
    logged: Sequence[str] = (),
    more: More | None = None,
) -> Robot:
    """The robot of a file with the joints of so many axes, all others locked where they are zero.

    joints: names in the order of the axes; () takes those of `more`, what stands beside the file,
    or that the logs name, `logged`, if the file has them all, or all that move, in the order of the
    file. Raises UsageError for the choice of joints, MachineError for a file that describes no
    machine whose torques can be calculated, or a tool or rotor of nothing.
    """
    pin, more = pinocchio(file), more or More(robot=file.name)
    tree = robot_xml(file)
    refuse_couplings(file, tree)
    refuse_negative(file, tree)
    refuse_odd_friction(file, tree)
    refuse_no_axis(file, tree)
    model = _model(pin, file, tree)
    moving = list(model.names)[1:]
    more.refuse_strange(moving_joints(tree, moving))
    named = joints or more.joints or (logged if {*logged} <= {*moving} else ())
    where = more.where("joints") if more.joints and not joints else OPTION
    chosen = chosen_joints(file, tree, moving, named, axes, where)
    refuse_other_order(logged, chosen, where)
    refuse_mimics(file, tree, chosen)
    kinds = [kind_of(file, name, model.joints[model.getJointId(name)]) for name in chosen]
    locked = [k for k, name in enumerate(model.names) if k and name not in chosen]
    # what stands on locked joints belongs to the bodies before them
    model = pin.buildReducedModel(model, locked, pin.neutral(model))
    places = tuple(model.getJointId(name) for name in chosen)
    model.gravity.linear = np.array(more.gravity or _gravity(file, tree))
    load = more.attach(pin, model, places)
    bodies = tuple(_body(pin, model, place) for place in places)
    for name, place, body in zip(chosen, places, bodies, strict=True):
        _refuse_impossible(file, name, body, model.inertias[place])
    inertias = [model.inertias[place].inertia for place in places]
    said = tuple(odd_moments(file, bodies, inertias))
    if logged and not named:
        said += (
            f"the logs' joints {', '.join(logged)} have no such names in {file}: their axes are"
            f" taken for {', '.join(chosen)}, in this order ({OPTION} says another)",
        )
    return Robot(model, tuple(chosen), places, tuple(kinds), bodies, said, more, load)


def robot_xml(file: Path) -> ElementTree.Element:
    """The file as XML; an SDF as the URDF of its model. MachineError for a file that is none."""
    tree = _tree(file)
    return as_urdf(file, tree) if tree.tag == "sdf" else tree


def _gravity(file: Path, tree: ElementTree.Element) -> tuple[float, ...]:
    """What MJCF says of it (3,) [m/s2], which Pinocchio does not read; else downwards."""
    option = tree.find("option[@gravity]")
    text = "0 0 -9.81" if option is None else option.get("gravity", "")
    try:
        x, y, z = (float(word) for word in text.split())
    except ValueError:
        raise MachineError(f"{file}: <option> has gravity {text!r}: three numbers") from None
    return x, y, z


def _tree(file: Path) -> ElementTree.Element:
    try:
        tree = ElementTree.parse(file).getroot()
    except OSError as error:
        raise MachineError(unreadable(file, error)) from None
    except ElementTree.ParseError as error:
        raise MachineError(f"{file}: no XML: {error}") from None
    if tree.tag != ROOTS[file.suffix]:
        raise MachineError(
            f"{file}: begins with <{tree.tag}>, a {file.suffix} file with <{ROOTS[file.suffix]}>"
        )
    return tree


def _model(pin: Any, file: Path, tree: ElementTree.Element) -> Any:
    """Pinocchio's model; shapes are taken out, so that no file of a mesh is missed."""
    for link in tree.findall("link"):
        for kind in ("visual", "collision"):
            for shape in link.findall(kind):
                link.remove(shape)
    said, wrong = list[str](), None
    with _heard(said):
        try:
            if tree.tag == "robot":
                model = pin.buildModelFromXML(ElementTree.tostring(tree, encoding="unicode"))
            else:
                model = pin.buildModelFromMJCF(str(file.resolve()))
        except Exception as error:
            wrong = error
    # a link whose <inertial> cannot be read is built without it, which is no error there
    errors = [line.removeprefix("Error:").strip() for line in said if line.startswith("Error:")]
    if wrong or errors:
        raise MachineError(f"{file}: Pinocchio cannot read it: {(*errors, wrong)[0]}") from wrong
    return model[0] if isinstance(model, tuple) else model


@contextmanager
def _heard(lines: list[str]) -> Iterator[None]:
    """What libraries in C++ print meanwhile goes into `lines`, not onto the terminal."""
    sys.stderr.flush()
    with tempfile.TemporaryFile() as file:
        kept = os.dup(2)
        os.dup2(file.fileno(), 2)
        try:
            yield
        finally:
            os.dup2(kept, 2)
            os.close(kept)
            file.seek(0)
            lines += file.read().decode(errors="replace").splitlines()


def _body(pin: Any, model: Any, place: int) -> str:
    """The first link that a joint moves."""
    bodies = [f for f in model.frames if f.type == pin.FrameType.BODY and f.parentJoint == place]
    return bodies[0].name if bodies else str(model.names[place])


def _refuse_impossible(file: Path, joint: str, body: str, inertia: Any) -> None:
    """MachineError for a body without mass, or with moments that no body has."""
    if not inertia.mass > 0:
        raise MachineError(
            f"{file}: what joint {joint} moves has no mass: write an <inertial> for link {body};"
            " it may be rough, with --tolerance mass=0.3"
        )
    moments = np.linalg.eigvalsh(inertia.inertia)
    if moments[0] < -SHORT_OF * moments[-1]:
        raise MachineError(
            f"{file}: link {body} has a negative moment of inertia about its centre of mass:"
            f" principal moments {', '.join(f'{v:.3g}' for v in moments)} kg m2"
        )

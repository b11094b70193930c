"""A robot's file with other parameters: the same URDF or MJCF, its bodies' inertias, and what the
format has a place for of friction, damping and rotors, in place of what was there.

Parts on fixed or locked joints belong to the body before them. They stay as they are, and the body
takes the difference; where that is no body, as what was found leaves none, they are scaled down. A
tool that a TOML adds stays there.
"""

from __future__ import annotations

import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from lxml import etree
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Motion
from flexhex.diagnosis.basemodels.robot_effects import friction_of
from flexhex.diagnosis.basemodels.robot_file import pinocchio, read_robot
from flexhex.diagnosis.basemodels.robots import RobotBase
from flexhex.diagnosis.basemodels.tolerances import RobotTolerance
from flexhex.diagnosis.estimation.bodies import consistent
from flexhex.fmus.common.errors import MachineError

Array = NDArray[np.float64]
PLACES = {".urdf": ("F_c", "d"), ".xml": ("F_c", "d", "J_r", "m_r")}
"""Parameters of axes that a format has a place for."""
SAME = 1e-9
"""Difference of torques, relative to the largest, from those of the file that is read back."""
STATES = 50
DIGITS = 12
"""Of numbers that are written."""


def write_robot(
    path: Path, base: RobotBase, file: Path, values: Mapping[str, float]
) -> tuple[list[str], dict[str, float]]:
    """Write `file` with these values, by the names of `base.linear` and `F_c[i]`, `d[i]`; the names
    of values that the format has no place for, and the shares to which parts were scaled. Read back
    before it is there: MachineError, and no file, where it does not give the same torques."""
    root = etree.parse(str(file), etree.XMLParser(resolve_entities=False)).getroot()
    writer = _Urdf(root, file) if file.suffix == ".urdf" else _Mjcf(root, file)
    robot, p, pin = base.robot, np.array([values[k.name] for k in base.linear]), pinocchio(file)
    frames = {f.name: f.placement for f in robot.model.frames if f.type == pin.FrameType.BODY}
    scaled = dict[str, float]()
    for k, (place, joint, body) in enumerate(zip(*_named(base), strict=True)):
        parts = _parts(base, place, writer)
        rest = sum(parts.values(), start=np.zeros(10))
        total, share = _without_tool(base, k, p[10 * k : 10 * k + 10]), 1.0
        while not consistent(total - share * rest):
            share /= 2
        own = pin.Inertia.FromDynamicParameters(total - share * rest)
        writer.inertia(body, frames[body].actInv(own))
        for name, part in parts.items() if share < 1 else ():
            less = pin.Inertia.FromDynamicParameters(share * part)
            writer.inertia(name, frames[name].actInv(less))
            scaled[name] = share
        friction = {n: values.get(f"{n}[{k + 1}]") for n in PLACES[file.suffix]}
        writer.axis(joint, {n: v for n, v in friction.items() if v is not None})
    # a file of its own may be read by nobody else
    with tempfile.TemporaryDirectory(dir=path.resolve().parent) as folder:
        made = Path(folder) / f"made{file.suffix}"
        made.write_text(_text(root), encoding="utf-8")
        _refuse_other(made, path, base, values)
        made.replace(path)
    placed = {known.name for known in base.linear[: 10 * base.n]}
    placed |= {f"{n}[{k + 1}]" for n in PLACES[file.suffix] for k in range(base.n)}
    return [name for name in values if name not in placed], scaled


def _named(base: RobotBase) -> tuple[Sequence[int], Sequence[str], Sequence[str]]:
    return base.robot.places, base.robot.joints, base.robot.bodies


def _parts(base: RobotBase, place: int, writer: _Urdf | _Mjcf) -> dict[str, Array]:
    """The ten parameters, about the joint, of the parts that belong to what a joint moves, by the
    names of their bodies."""
    frames, inertias = base.robot.model.frames, dict[str, Array]()
    carriers = dict[str, str]()
    for number, frame in enumerate(frames):
        if frame.parentJoint != place or not frame.inertia.mass > 0:
            continue
        inertias[frame.name] = frame.placement.act(frame.inertia).toDynamicParameters()
        # a locked joint's frame has the inertia of what is fixed to its body, too
        while not writer.locked(frames[number].name) and frames[number].parentFrame != number:
            number = frames[number].parentFrame
        carriers[frame.name] = frames[number].name
    for name, carrier in carriers.items():
        if carrier != name and carrier in inertias:
            inertias[carrier] = inertias[carrier] - inertias[name]
    return {writer.part(name): ten for name, ten in inertias.items() if ten[0] > 0}


def _without_tool(base: RobotBase, axis: int, ten: Array) -> Array:
    """The ten parameters of an axis' body without what a TOML adds to it.

    MachineError where the body was found lighter than that.
    """
    load = base.robot.load
    if load is None or load.axis != axis:
        return ten
    if not consistent(ten - load.tool):
        raise MachineError(
            f"{base.robot.more.where('tool')}: what joint {base.robot.joints[axis]} moves was found"
            " too light for it: correct it, or write .json instead"
        )
    return ten - load.tool


class _Urdf:
    """<link><inertial> about the link's frame, which is the joint's; <joint><dynamics>."""

    def __init__(self, root: Any, file: Path) -> None:
        self.root, self.file = root, file
        self.joints = {joint.get("name"): joint for joint in root.findall("joint")}
        self.links = {link.get("name"): link for link in root.findall("link")}

    def locked(self, frame: str) -> bool:
        """Whether a frame is that of a joint that could move."""
        return frame in self.joints and self.joints[frame].get("type") != "fixed"

    def part(self, joint: str) -> str:
        """The link on a fixed or locked joint."""
        return str(self.joints[joint].find("child").get("link"))

    def inertia(self, name: str, inertia: Any) -> None:
        """A link's mass, centre and inertia."""
        inertial = _child(self.links[name], "inertial")
        _child(inertial, "origin").attrib.update(
            {"xyz": _numbers(inertia.lever.round(DIGITS)), "rpy": "0 0 0"}
        )
        _child(inertial, "mass").set("value", _number(inertia.mass))
        names = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
        values = _numbers(inertia.inertia[np.triu_indices(3)]).split()
        _child(inertial, "inertia").attrib.update(zip(names, values, strict=True))

    def axis(self, joint: str, friction: Mapping[str, float]) -> None:
        """Friction and damping of a joint."""
        for name, attribute in (("d", "damping"), ("F_c", "friction")):
            if name in friction:
                dynamics = _child(self.joints[joint], "dynamics")
                dynamics.set(attribute, _number(friction[name]))


class _Mjcf:
    """<body><inertial> about the body's frame; attributes of <joint>."""

    def __init__(self, root: Any, file: Path) -> None:
        self.root, self.file = root, file
        for compiler in root.iter("compiler"):
            for name, bad in (("inertiafromgeom", ("true",)), ("settotalmass", None)):
                if name in compiler.attrib and (bad is None or compiler.get(name) in bad):
                    raise MachineError(
                        f'{file}: <compiler {name}="{compiler.get(name)}"> replaces the masses'
                        " of the file: take it out, then write"
                    )
        if root.find(".//include") is not None:
            raise MachineError(
                f"{file}: has parts in other files (<include>): put them into one, then write"
            )
        self.joints = {j.get("name"): j for j in root.findall("worldbody//joint")}
        self.bodies = {b.get("name"): b for b in root.findall("worldbody//body")}

    def locked(self, frame: str) -> bool:
        """Whether a frame is that of a joint."""
        return frame in self.joints

    def part(self, frame: str) -> str:
        """The body that is fixed, or stands on a locked joint."""
        if frame in self.joints:
            return str(self.joints[frame].getparent().get("name"))
        return frame.removesuffix("_fixed")

    def inertia(self, name: str, inertia: Any) -> None:
        """A body's mass, centre and inertia."""
        if name not in self.bodies:
            raise MachineError(f"{self.file}: a body has no name: name each one, then write")
        element, J = _child(self.bodies[name], "inertial"), inertia.inertia
        for other in ("quat", "axisangle", "xyaxes", "zaxis", "euler", "diaginertia"):
            element.attrib.pop(other, None)
        six = J[0, 0], J[1, 1], J[2, 2], J[0, 1], J[0, 2], J[1, 2]
        numbers = {"pos": _numbers(inertia.lever.round(DIGITS)), "fullinertia": _numbers(six)}
        element.attrib.update({"mass": _number(inertia.mass), **numbers})

    def axis(self, joint: str, friction: Mapping[str, float]) -> None:
        """Friction, damping and rotor of a joint."""
        element = self.joints[joint]
        kinds = {"d": "damping", "F_c": "frictionloss", "J_r": "armature", "m_r": "armature"}
        for name, value in friction.items():
            element.set(kinds[name], _number(value))


def _refuse_other(written: Path, path: Path, base: RobotBase, values: Mapping[str, float]) -> None:
    """MachineError where the file that is read back has other torques."""
    robot = read_robot(written, base.robot.joints, base.n, more=base.robot.more)
    back = RobotBase(written, robot, RobotTolerance(), 1e-3)
    rng = np.random.default_rng(0)
    motion = Motion(0.0, 1e-3, *rng.standard_normal((3, STATES, base.n)))
    p = np.array([values[known.name] for known in base.linear])
    own, at = np.array([known.nominal for known in back.linear]), 10 * base.n
    own[at:] = p[at:]
    wanted, actual = base.torque(motion, p), back.torque(motion, own)
    order = [robot.model.joints[place].idx_v for place in robot.places]
    model, pairs = robot.model, [(wanted, actual)]
    for name, read in (("d", model.damping), ("F_c", friction_of(model)),
                       ("J_r", model.armature), ("m_r", model.armature)):  # fmt: skip
        for k, place in enumerate(order):
            if name in PLACES[written.suffix] and f"{name}[{k + 1}]" in values:
                pairs.append((np.array(values[f"{name}[{k + 1}]"]), np.array(read[place])))
    for one, other in pairs:
        if np.abs(one - other).max() > SAME * max(float(np.abs(one).max()), 1e-300):
            raise MachineError(
                f"{path}: read back, it has other torques than were written: something in the file"
                " replaces its inertias or friction; write .json instead"
            )


def _text(root: Any) -> str:
    """The whole file, with the comments before and behind its root."""
    nodes = [*reversed([*root.itersiblings(preceding=True)]), root, *root.itersiblings()]
    lines = [etree.tostring(node, encoding="unicode", with_tail=False) for node in nodes]
    return "\n".join(['<?xml version="1.0" encoding="utf-8"?>', *lines, ""])


def _child(element: Any, name: str) -> Any:
    """An element's only child of a name, which is made where there is none, indented as the others
    are; of several the first stays."""
    there = element.findall(name)
    for other in there[1:]:
        element.remove(other)
    if there:
        return there[0]
    made = etree.Element(name)
    made.tail = element.text
    element.insert(0, made)
    return made


def _number(value: float) -> str:
    return repr(float(f"{value:.{DIGITS}g}"))


def _numbers(values: Any) -> str:
    """Several of one kind: what rounding makes of zero beside the largest is zero."""
    most = np.abs(values).max()
    return " ".join(_number(v if abs(v) > most * 10.0**-DIGITS else 0.0) for v in values)

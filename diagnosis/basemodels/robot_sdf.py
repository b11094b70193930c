"""SDF (Gazebo) as URDF, by ROD: a pure Python library, as Pinocchio's package reads no SDF."""

from __future__ import annotations

import importlib
import logging
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from flexhex.fmus.common.errors import MachineError, UsageError

TYPES = ("fixed", "revolute", "continuous", "prismatic")
"""Joints that URDF has, too."""


def as_urdf(file: Path, tree: ElementTree.Element) -> ElementTree.Element:
    """The URDF of the file's only model.

    UsageError without the library, MachineError for what URDF cannot say or the library not read.
    """
    _refuse(file, tree)
    _with_springs(tree)
    try:
        rod: Any = importlib.import_module("rod")
        exporter: Any = importlib.import_module("rod.urdf.exporter")
    except ImportError:
        raise UsageError(f"--base {file}: needs ROD: pip install 'flexhex[robots]'") from None
    # it also reads URDF, by a program of Gazebo, and warns that there is none
    logging.getLogger("rod").setLevel(logging.ERROR)
    try:
        sdf = rod.Sdf.load(ElementTree.tostring(tree, encoding="unicode"), is_urdf=False)
        # what it cannot read of one link it says of none
        if not sdf.models()[0].links():
            raise MachineError(
                f"{file}: ROD reads no <link> of it: each <inertial> wants a <mass> and an"
                " <inertia> with ixx, iyy, izz"
            )
        urdf = ElementTree.fromstring(exporter.UrdfExporter().to_urdf_string(sdf))
    except MachineError:
        raise
    except Exception as error:
        raise MachineError(f"{file}: ROD cannot make a URDF of it: {error}") from error
    for joint in urdf.iter("joint"):
        # SDF may leave limits out, URDF may not
        if joint.get("type") in ("revolute", "prismatic") and joint.find("limit") is None:
            ElementTree.SubElement(joint, "limit", {"effort": "0", "velocity": "0"})
    return urdf


def _with_springs(tree: ElementTree.Element) -> None:
    """<dynamics> with springs of nothing, which SDF may leave out and the library wants."""
    for dynamics in tree.iter("dynamics"):
        for name in ("damping", "friction", "spring_reference", "spring_stiffness"):
            if dynamics.find(name) is None:
                ElementTree.SubElement(dynamics, name).text = "0"


def _refuse(file: Path, tree: ElementTree.Element) -> None:
    if len(tree.findall(".//model")) != 1 or tree.find(".//include") is not None:
        raise MachineError(
            f"{file}: wants one <model> and no <include>: write the robot into a file of its own"
        )
    if tree.find(".//mimic") is not None:
        raise MachineError(f"{file}: <mimic>: coupled joints are not supported")
    for joint in tree.iter("joint"):
        if joint.get("type") not in TYPES:
            raise MachineError(
                f"{file}: joint {joint.get('name')} is of type {joint.get('type')}: there are"
                f" {', '.join(TYPES)}"
            )

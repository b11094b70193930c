"""What no robot has, in its file: masses below zero, axes without a direction, odd inertias."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from difflib import get_close_matches
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from flexhex.fmus.common.errors import MachineError

Array = NDArray[np.float64]
RUBS = ("damping", "frictionloss", "armature")
"""Attributes of MJCF's joints."""
DYNAMICS = ("damping", "friction")
"""Those of URDF's <dynamics>."""
ROUNDED = 0.01
"""Relative excess of a moment of inertia that rounding in a file may make: beyond it there is a
remark, and nothing else depends on it."""


def refuse_negative(file: Path, tree: ElementTree.Element) -> None:
    """MachineError for a link of a negative mass, which what is fixed to it may hide."""
    for link in (*tree.iter("link"), *tree.iter("body")):
        for inertial in link.findall("inertial"):
            masses = [
                inertial.get("mass", ""),
                *(m.get("value", "") for m in inertial.findall("mass")),
            ]
            for mass in masses:
                if mass.strip().startswith("-"):
                    raise MachineError(
                        f"{file}: link {link.get('name')} has a mass of {mass} kg: correct it"
                    )


def refuse_odd_friction(file: Path, tree: ElementTree.Element) -> None:
    """MachineError for friction, damping or a rotor of a joint that is no number or below zero, or
    is misspelt."""
    for joint in tree.iter("joint"):
        listed, called = {name: joint.get(name) for name in RUBS}, joint.get("name", "<default>")
        for dynamics in joint.findall("dynamics"):
            for name in {*dynamics.attrib} - {*DYNAMICS}:
                if close := get_close_matches(name, DYNAMICS, 1):
                    raise MachineError(
                        f"{file}: joint {called}: <dynamics> has no {name}: is it {close[0]}?"
                    )
            listed |= {name: dynamics.get(name) for name in DYNAMICS}
        for name, text in listed.items():
            # MJCF takes several, of a joint with several degrees of freedom
            for word in (text or "0").split() if text != "" else [""]:
                try:
                    good = 0 <= float(word) < np.inf
                except ValueError:
                    good = False
                if not good:
                    raise MachineError(
                        f"{file}: joint {called} has {name}={text!r}: a number, not below zero"
                    )


def refuse_no_axis(file: Path, tree: ElementTree.Element) -> None:
    """MachineError for a joint whose axis has no direction; one that is fixed needs none."""
    for joint in tree.iter("joint"):
        axis = None if joint.get("type") == "fixed" else joint.find("axis")
        text = "" if axis is None else axis.get("xyz") or axis.findtext("xyz") or ""
        try:
            numbers = [float(word) for word in text.split()]
        except ValueError:
            continue  # what is no number is refused by who reads it
        if numbers and not any(numbers):
            name = joint.get("name")
            raise MachineError(f"{file}: joint {name} has the axis {text.strip()}: no direction")


def odd_moments(file: Path, bodies: Sequence[str], inertias: Sequence[Array]) -> Iterator[str]:
    """A sentence on each body whose moments of inertia (3, 3) [kg m2] about its centre of mass no
    body has: of the principal ones none is larger than the sum of the others."""
    for body, inertia in zip(bodies, inertias, strict=True):
        least, middle, most = np.linalg.eigvalsh(inertia)
        if most > (1 + ROUNDED) * (least + middle):
            yield (
                f"{file}: no body has the principal moments {least:.3g}, {middle:.3g} and"
                f" {most:.3g} kg m2 of link {body}, as the largest is more than the sum of the"
                " others: are they about the centre of mass, each in its place? They are kept"
            )

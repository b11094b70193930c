"""What no robot has, in the XML of its file: masses below zero, axes without a direction."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

from flexhex.fmus.common.errors import MachineError


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


def refuse_no_axis(file: Path, tree: ElementTree.Element) -> None:
    """MachineError for a joint whose axis has no direction."""
    for joint in tree.iter("joint"):
        axis = joint.find("axis")
        text = "" if axis is None else axis.get("xyz") or axis.findtext("xyz") or ""
        try:
            numbers = [float(word) for word in text.split()]
        except ValueError:
            continue  # what is no number is refused by who reads it
        if numbers and not any(numbers):
            name = joint.get("name")
            raise MachineError(f"{file}: joint {name} has the axis {text.strip()}: no direction")

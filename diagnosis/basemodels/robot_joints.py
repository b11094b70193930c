"""Which joints of a robot's file are the axes of the logs, and those that none can be."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from flexhex.diagnosis.basemodels.robot_more import meant
from flexhex.diagnosis.kinds import LINEAR, ROTARY, Kind
from flexhex.fmus.common.errors import MachineError, UsageError

TURNS = ("JointModelR",)
OPTION = "--joints"
"""Who names joints, where no file does."""
SLIDES = ("JointModelPX", "JointModelPY", "JointModelPZ", "JointModelPrismatic")


def moving_joints(tree: ElementTree.Element, known: Sequence[str]) -> list[str]:
    """Names of the joints that move, in the order of the file."""
    names = [joint.get("name", "") for joint in tree.iter("joint")]
    return [*dict.fromkeys(name for name in names if name in known)] or list(known)


def refuse_other_order(logged: Sequence[str], chosen: Sequence[str], where: str) -> None:
    """UsageError, or of a file's choice MachineError, where logs name the same joints in another
    order."""
    pairs = zip(logged, chosen, strict=False)
    other = next(((k, *pair) for k, pair in enumerate(pairs, start=1) if pair[0] != pair[1]), None)
    if other is None or {*logged} != {*chosen}:
        return
    axis, theirs, ours = other
    error = UsageError if where == OPTION else MachineError
    raise error(
        f"{where}: {ours} is axis {axis}, where the logs name {theirs}: leave this choice out, as"
        " the logs say which joint is which, or mend the names in them"
    )


def chosen_joints(
    file: Path,
    tree: ElementTree.Element,
    known: list[str],
    joints: Sequence[str],
    axes: int,
    where: str,
) -> list[str]:
    """Joints of so many axes, in their order: those named, by `where`, or all that move.

    known: joints that move. UsageError or, of a file's choice, MachineError for those that there
    are not, or another number.
    """
    error = UsageError if where == OPTION else MachineError
    listed = moving_joints(tree, known)
    for name in joints:
        if name not in known:
            fixed = name in [joint.get("name") for joint in tree.iter("joint")]
            what = "is fixed" if fixed else "does not exist"
            raise error(f"{where}: {name} {what} in {file}{meant(name, listed)}")
    twice = [name for k, name in enumerate(joints) if name in joints[:k]]
    if twice:
        raise error(f"{where}: {twice[0]} is named twice")
    if not listed:
        raise MachineError(f"{file}: no joint moves")
    chosen = list(joints) or [name for name in listed if name not in _mimics(tree)]
    if len(chosen) != axes:
        raise error(
            f"{file if where == OPTION else where}: {len(chosen)} joints ({', '.join(chosen)}), the"
            f" logs have {axes} axes: name those of the logs in their order, --joints NAME,NAME,..."
        )
    return chosen


def _mimics(tree: ElementTree.Element) -> dict[str, str]:
    """Joints that follow another one, and which."""
    mimics = [(joint, joint.find("mimic")) for joint in tree.iter("joint")]
    return {j.get("name", ""): m.get("joint", "") for j, m in mimics if m is not None}


def refuse_mimics(file: Path, tree: ElementTree.Element, chosen: Sequence[str]) -> None:
    """MachineError for an axis that follows a joint or leads one."""
    for name, leader in _mimics(tree).items():
        if name in chosen or leader in chosen:
            raise MachineError(
                f"{file}: joint {name} follows {leader} (<mimic>): coupled joints are not"
                " supported; take the tag out if it can be taken for locked"
            )


def refuse_couplings(file: Path, tree: ElementTree.Element) -> None:
    """MachineError for what MJCF couples joints by."""
    for element in tree.iterfind("equality/*"):
        raise MachineError(
            f"{file}: <equality> with <{element.tag}>: closed loops and coupled joints are not"
            " supported, a base model of your own can have them (docs/own-base.md)"
        )


def kind_of(file: Path, name: str, joint: Any) -> Kind:
    """Whether a joint of Pinocchio's turns or slides; MachineError for others."""
    kind = joint.shortname()
    if kind.startswith(TURNS):
        return ROTARY
    if kind.startswith(SLIDES):
        return LINEAR
    raise MachineError(
        f"{file}: joint {name} is a {kind.removeprefix('JointModel')}: an axis turns or slides;"
        " replace it, or lock it by leaving it out of --joints"
    )

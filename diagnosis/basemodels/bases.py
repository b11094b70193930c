"""Base models by name: the only place where the diagnosis knows which machines there are."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

from flexhex.diagnosis.basemodels.axis import AxisBase
from flexhex.diagnosis.basemodels.base import Base
from flexhex.diagnosis.basemodels.hexapod import HexapodBase
from flexhex.diagnosis.basemodels.own import NEEDED, OwnBase
from flexhex.diagnosis.basemodels.robot_file import is_robot, read_robot, refuse_robot
from flexhex.diagnosis.basemodels.robot_more import read_more
from flexhex.diagnosis.basemodels.robots import RobotBase
from flexhex.diagnosis.basemodels.tolerances import with_tolerance
from flexhex.diagnosis.logs import Log
from flexhex.fmus.common.errors import LogError, UsageError
from flexhex.fmus.common.machine_file import load_machine
from flexhex.fmus.common.user_code import (
    BASE_GROUP,
    from_file,
    from_package,
    offered,
    refuse_missing,
    split,
)

WHAT = "base model"
NO_TOLERANCE: Mapping[str, float] = MappingProxyType({})
"""Those of the machine file, all of them."""


def _hexapod(
    machine_file: Path | None, log: Log, tolerance: Mapping[str, float] = NO_TOLERANCE
) -> Base:
    if machine_file is None:
        raise LogError("no machine file given: the hexapod needs one (--machine)")
    machine = load_machine(machine_file)
    other = "add --base with a robot's file, or --base axis for axes without a model"
    log.refuse_width(machine.n_arms, other)
    known = with_tolerance(machine.tolerance, tolerance)
    return HexapodBase(machine.model_copy(update={"tolerance": known}))


def _axis(machine_file: Path | None, log: Log) -> Base:
    return AxisBase(log["theta"].width, log["theta"].ts, log.kinds)


BASES: Mapping[str, Callable[[Path | None, Log], Base]] = {
    "hexapod": _hexapod,
    "axis": _axis,
}


def known_base(name: str) -> None:
    """UsageError for a base model that there is not, before anything is read."""
    if is_robot(name):
        refuse_robot(Path(name))
    elif (own := split(name)) is not None:
        refuse_missing(own[0], name, "--base")
    elif name not in BASES and name not in offered(BASE_GROUP):
        listed = ", ".join((*BASES, *offered(BASE_GROUP)))
        raise UsageError(
            f"--base {name}: there are {listed}, a robot's file (.urdf, .xml, .sdf, .toml), and a"
            " base model of your own, FILE.py:NAME (`flexhex init base.py` writes an example)"
        )


def base_of(
    name: str,
    machine_file: Path | None,
    log: Log,
    tolerance: Mapping[str, float] = NO_TOLERANCE,
    joints: Sequence[str] = (),
) -> Base:
    """The base model called `name` for logs like this one: a log of another number of axes is
    refused before a model with a file of its own is compiled.

    tolerance: in place of the machine file's, by the keys of its section. joints: of a robot's
    file, in the order of the axes. UsageError for an unknown name, or for tolerances or joints of
    a base model that has none.
    """
    known_base(name)
    if is_robot(name):
        more = read_more(name)
        robot = read_robot(more.file, joints, log["theta"].width, log.joints, more)
        known = with_tolerance(more.tolerance, tolerance)
        return RobotBase(more.file, robot, known, log["theta"].ts)
    if joints:
        raise UsageError(f"--joints: base model {name} is no robot's file: take it out")
    if tolerance:
        if name != "hexapod":
            raise UsageError(f"tolerance: base model {name} reads no machine file: take it out")
        return _hexapod(machine_file, log, tolerance)
    if (own := split(name)) is not None:
        return OwnBase(from_file(*own, NEEDED, "--base", WHAT), name, log)
    if name in BASES:
        return BASES[name](machine_file, log)
    return OwnBase(from_package(offered(BASE_GROUP)[name], WHAT), f"{WHAT} {name}", log)

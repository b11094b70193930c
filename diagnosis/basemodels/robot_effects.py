"""Effects that a robot's files state: friction and damping of its file, and those that the
TOML beside it has.

    [[effects]]
    id = "coulomb_friction"
    axes = [1, 3]             # of the logs
    [effects.parameters]
    F_c = [12.1, 8.0]         # N m; a force where the joint slides
    s_0 = 0.001               # rad
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from flexhex.diagnosis.kinds import axes_named
from flexhex.fmus.common.effects import library
from flexhex.fmus.common.errors import MachineError
from flexhex.fmus.common.machine.complaints import complaints
from flexhex.fmus.common.machine.effect_use import EffectUse, Elsewhere
from flexhex.fmus.common.user_code import absolute

if TYPE_CHECKING:
    from flexhex.diagnosis.basemodels.robot_file import Robot

RUBS = {
    "coulomb_friction": ("F_c", "upperDryFrictionLimit", "friction"),
    "viscous_friction": ("d_v", "damping", "damping"),
}
"""Effects that a robot's file has a place for: gain, Pinocchio's name, and what it is called."""


def effects_of(file: Path, robot: Robot) -> tuple[EffectUse, ...]:
    """All of them; what the TOML says of an axis stands in the place of the file's friction there.

    MachineError for an entry that is none, or friction below zero.
    """
    listed = [_read(robot, k, entry) for k, entry in enumerate(robot.more.effects, start=1)]
    told = {
        (id, axis) for use in listed for id in (use.id, use.effect.extends) for axis in use.axes
    }
    for id, (gain, attribute, what) in RUBS.items():
        axes, values = list[int](), list[float]()
        for axis, (joint, place) in enumerate(zip(robot.joints, robot.places, strict=True), 1):
            value = float(getattr(robot.model, attribute)[robot.model.joints[place].idx_v])
            if value < 0:
                raise MachineError(f"{file}: joint {joint} has a {what} of {value:g}: correct it")
            if value and (id, axis) not in told:
                axes.append(axis)
                values.append(value)
        if axes:
            start = {s.name: s.start for s in library()[id].shapes}
            listed.append(EffectUse.of(id, axes, **{gain: values}, **start))
    return tuple(listed)


def _read(robot: Robot, number: int, entry: dict[str, Any]) -> EffectUse:
    """An entry of the TOML."""
    where, n = robot.more.where(f"effects.{number}"), len(robot.joints)
    axes = entry.get("axes")
    there = [a for a in axes if isinstance(a, int)] if isinstance(axes, list) else []
    strange = [axis for axis in there if not 1 <= axis <= n]
    if strange:
        raise MachineError(f"{where}: axes: {strange[0]}, the logs have 1 to {n}")
    kinds = {robot.kinds[axis - 1] for axis in there}
    if len(kinds) > 1:
        text = axes_named(axis - 1 for axis in there)
        raise MachineError(f"{where}: {text}: some turn, some slide: write an entry for each kind")
    kind = kinds.pop() if kinds else robot.kinds[0]
    if isinstance(id := entry.get("id"), str):
        entry = entry | {"id": absolute(id, robot.more.folder)}
    try:
        use = EffectUse.model_validate(entry, context=Elsewhere(kind.unit))
    except ValidationError as error:
        raise MachineError("\n".join(complaints(where, EffectUse, error.errors()))) from None
    if use.effect.acts_on not in ("torque", "drive") or use.effect.geared:
        raise MachineError(f"{where}: {use.id} is no torque of the motion: take it out")
    return use

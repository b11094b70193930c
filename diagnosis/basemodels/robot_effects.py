"""Effects that a robot's files state: friction and damping of its file, and those that the TOML
beside it has.

    [[effects]]
    id = "coulomb_friction"
    axes = [1, 3]             # of the logs
    [effects.parameters]
    F_c = [12.1, 8.0]         # N m; a force where the joint slides
    s_0 = 0.001               # rad
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from flexhex.diagnosis.basemodels.robot_more import meant
from flexhex.diagnosis.kinds import Kind, axes_named
from flexhex.fmus.common.effects import Effect, library
from flexhex.fmus.common.errors import MachineError
from flexhex.fmus.common.machine.complaints import complaints
from flexhex.fmus.common.machine.effect_use import EffectUse, Elsewhere
from flexhex.fmus.common.user_code import absolute

if TYPE_CHECKING:
    from flexhex.diagnosis.basemodels.robot_file import Robot

FRICTION = "upperDryFrictionLimit", "friction"
"""What Pinocchio calls it, since its version 4 and before."""


def friction_of(model: Any) -> Any:
    """Dry friction of the joints of Pinocchio's model, in the order of its rates [N m, N]."""
    return next(getattr(model, name) for name in FRICTION if hasattr(model, name))


def effects_of(file: Path, robot: Robot) -> tuple[EffectUse, ...]:
    """All of them; what the TOML says of an axis stands in the place of the file's friction there.

    MachineError for an entry that is none.
    """
    listed = [_read(robot, k, entry) for k, entry in enumerate(robot.more.effects, start=1)]
    _refuse_twice(robot, listed)
    told = {(id, axis) for use in listed for id in _kinds(use.effect) for axis in use.axes}
    model = robot.model
    for id, gain, values in (
        ("coulomb_friction", "F_c", friction_of(model)),
        ("viscous_friction", "d_v", model.damping),
    ):
        own = [float(values[model.joints[place].idx_v]) for place in robot.places]
        axes = [k for k, value in enumerate(own, start=1) if value and (id, k) not in told]
        for kind in dict.fromkeys(robot.kinds[axis - 1] for axis in axes):
            mine = [axis for axis in axes if robot.kinds[axis - 1] is kind]
            # a file has no form of friction: it turns over at once
            shape = {shape.name: shape.low for shape in library()[id].shapes}
            parameters = {gain: [own[axis - 1] for axis in mine], **shape}
            entry = {"id": id, "axes": mine, "parameters": parameters}
            listed.append(_use(entry, kind, str(file)))
    return tuple(listed)


def _kinds(effect: Effect) -> tuple[str, ...]:
    """Its id, and that of the effect that it has in its gains."""
    return (effect.id, effect.extends) if effect.extends else (effect.id,)


def _refuse_twice(robot: Robot, uses: Sequence[EffectUse]) -> None:
    """MachineError for what an axis has more often than it can."""
    seen = dict[tuple[str, int], list[EffectUse]]()
    for k, use in enumerate(uses, start=1):
        for axis in use.axes:
            for id in _kinds(use.effect):
                others = seen.setdefault((id, axis), [])
                alike = any(other.id != use.id or other.shape == use.shape for other in others)
                if alike or len(others) >= use.effect.most:
                    raise MachineError(
                        f"{robot.more.where(f'effects.{k}')}: axis {axis} has {others[0].id}"
                        " already: write one entry with the sum of both"
                    )
                others.append(use)


def _read(robot: Robot, number: int, entry: dict[str, Any]) -> EffectUse:
    """An entry of the TOML."""
    where, n = robot.more.where(f"effects.{number}"), len(robot.joints)
    axes = entry.get("axes")
    if isinstance(axes, list):
        axes = [_axis(robot, where, axis) for axis in axes]
        entry = entry | {"axes": axes}
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
    use = _use(entry, kind, where)
    effect = use.effect
    timed = effect.line or any(shape.of_time for shape in effect.shapes)
    if effect.acts_on not in ("torque", "drive") or effect.geared or effect.feedforward or timed:
        raise MachineError(f"{where}: {use.id} is no torque that goes with the motion: take it out")
    for axis in there:
        if not effect.meets(axis, n, use.shape):
            raise MachineError(f"{where}: axis {axis} can have no {use.id} with these values")
    return use


def _axis(robot: Robot, where: str, axis: Any) -> Any:
    """The number of a joint that is named; any other as it is."""
    if not isinstance(axis, str):
        return axis
    if axis not in robot.joints:
        raise MachineError(f"{where}: axes: {axis} is no axis{meant(axis, robot.joints)}")
    return robot.joints.index(axis) + 1


def _use(entry: dict[str, Any], kind: Kind, where: str) -> EffectUse:
    try:
        return EffectUse.model_validate(entry, context=Elsewhere(kind.unit))
    except ValidationError as error:
        raise MachineError("\n".join(complaints(where, EffectUse, error.errors()))) from None

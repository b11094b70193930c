"""How well a file's values are known, where options replace what the file says."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, TypeVar

from pydantic import ValidationError

from flexhex.fmus.common.errors import UsageError
from flexhex.fmus.common.machine.quantity import quantity
from flexhex.fmus.common.machine.sections import BodyTolerance

Known = TypeVar("Known", bound=BodyTolerance)


class RobotTolerance(BodyTolerance):
    """How well a robot's file knows the robot: one standard deviation each. centre, geometry:
    relative to the longest way between joints or to a centre; gravity: direction of the robot's
    foot [rad]; effects: friction and other effects. 0: exact."""

    mass: Annotated[float, quantity("1", ge=0, le=1, bare=True)] = BodyTolerance().mass
    inertia: Annotated[float, quantity("1", ge=0, le=1, bare=True)] = BodyTolerance().inertia
    centre: Annotated[float, quantity("1", ge=0, le=1, bare=True)] = BodyTolerance().centre
    geometry: Annotated[float, quantity("1", ge=0, le=0.1, bare=True)] = BodyTolerance().geometry
    gravity: Annotated[float, quantity("1", ge=0, le=0.1, bare=True)] = 0.002
    effects: Annotated[float, quantity("1", ge=0, le=10, bare=True)] = 0.1


def with_tolerance(known: Known, given: Mapping[str, float]) -> Known:
    """Tolerances of a kind with some in their place. UsageError for one that this kind does not
    have, or one out of range."""
    kind = type(known)
    strange = [name for name in given if name not in kind.model_fields]
    if strange:
        listed = ", ".join(kind.model_fields)
        raise UsageError(f"tolerance {strange[0]!r}: there are {listed}")
    tables = {n: {"value": v, "unit": "1", "source": "assumed"} for n, v in given.items()}
    try:
        read = kind.model_validate(tables)
    except ValidationError as error:
        first = error.errors()[0]
        text = str(first["msg"]).removeprefix("Value error, ")
        raise UsageError(f"tolerance {first['loc'][0]} = {text}") from None
    return known.model_copy(update={name: getattr(read, name) for name in given})

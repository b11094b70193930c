"""Values of FMUs of any type through FMPy."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any


def values_of(slave: Any, variables: Iterable[Any]) -> list[float]:
    """Values of FMPy's variables, of a Boolean 0 or 1."""
    listed = []
    for v in variables:
        suffix = "Integer" if v.type == "Enumeration" else v.type
        listed += map(float, getattr(slave, f"get{suffix}")([v.valueReference]))
    return listed


def outputs_of(description: Any) -> Sequence[Any]:
    """The outputs in the order of the description."""
    return [v for v in description.modelVariables if v.causality == "output"]

"""An experiment that shows an effect."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Experiment:
    """A run of the reference FMU that shows an effect.

    kind: random, triangle, multisine or chirp; parameters: others of that FMU, by name;
    payload: (time [s], mass [kg]) schedule.
    """

    kind: str
    parameters: Mapping[str, float] = field(default_factory=dict)
    payload: tuple[tuple[float, float], ...] = ()

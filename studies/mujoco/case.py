"""What a case consists of."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from studies.mujoco.machine import Machine


@dataclass(frozen=True)
class Wanted:
    """An effect to hide: id, axes from 0, share of torque RMS there, seed."""

    id: str
    axes: tuple[int, ...]
    size: float
    seed: int


@dataclass(frozen=True)
class Noise:
    """white, coloured, wander, disturbance: RMS relative to the torque's; corner [Hz] of coloured
    and disturbance; time [s] of the wander; torque_step, relative to the torque's RMS."""

    white: float
    coloured: float
    wander: float
    disturbance: float
    corner: float
    time: float
    torque_step: float
    seed: int


@dataclass(frozen=True)
class Loop:
    """bandwidth: of the feedback, in multiples of the motion's frequency; integral: whether it has
    one; feedforward: none, gravity or full, by the machine file."""

    bandwidth: float
    integral: bool
    feedforward: str


@dataclass(frozen=True)
class Case:
    """All that is drawn. rate [Hz] of logs; substeps of the simulation; delay [cycles] of report
    behind command; trajectories: kind and seed, the last for tests where there are several;
    payload [kg] on the second half of the passes, announced in the logs' heads or not."""

    seed: int
    category: str
    machine: Machine
    written: Machine
    mass_error: float
    geometry_error: float
    rate: float
    substeps: int
    seconds: float
    trajectories: tuple[tuple[str, int], ...]
    passes: int
    loop: Loop
    noise: Noise
    encoder: float
    delay: int
    aligned: bool
    command: bool
    reference: bool
    ending: str
    hidden: tuple[Wanted, ...] = ()
    changes: tuple[dict[str, Any], ...] = field(default=())
    payload: float = 0.0
    announced: bool = False

    @property
    def step(self) -> float:
        """Of the simulation [s]."""
        return 1 / (self.rate * self.substeps)

"""What varies in a Monte Carlo study, and the random parameters of each of its runs.

Run number k of a seed is the same draw whatever the number of runs and whatever else varies,
so a study can grow. Both cases of a run get the same draw.
"""

from __future__ import annotations

import math
import random
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from flexhex.fmus.common.errors import UsageError
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.machine_file import truth_file
from flexhex.fmus.machine.truth import Truth, interface
from flexhex.simulation.cases import WARM

VARIED = {
    "noise": "seed of the noise",
    "payload": "mass at the end-effector from the start on",
    "age": "time since the machine was switched on",
    "drift": "offset torques that creep in",
    "truth": "the machine itself: inertias, stiffness, actuators, cogging; p stays as fitted",
    "trajectory": "seed of the setpoints",
}
"""What a study can draw anew for every run."""
DEFAULT_VARIED = ("noise", "payload", "age", "drift")
OF_MODEL = ("payload", "trajectory")
"""What can vary where the machine is its model, without a truth file."""
BUILT = ("mechanism", "actuator", "hidden_cogging")
"""Parameters of machine.fmu that `truth` draws."""
Values = Mapping[str, float | tuple[float, ...]]


@dataclass(frozen=True)
class StudyPlan:
    """What a study does: runs, judged time [s], seed, what varies, largest payload [kg] and
    age [s]."""

    runs: int = 20
    duration: float = 10.0
    seed: int = 1
    varied: tuple[str, ...] = DEFAULT_VARIED
    payload: float = 1.0
    age: float = 2 * WARM

    def check(self) -> None:
        """UsageError for a plan that cannot be."""
        if self.runs < 1 or self.seed < 0:
            raise UsageError(f"--runs {self.runs}, --seed {self.seed}: at least 1 and 0")
        sizes = {"duration": self.duration, "payload": self.payload, "age": self.age}
        for name, value in sizes.items():
            if not (math.isfinite(value) and value > 0):
                raise UsageError(f"--{name} {value:g}: must be above 0")
        if not self.varied:
            raise UsageError(f"--vary: all runs would be the same, choose of {', '.join(VARIED)}")
        for name in self.varied:
            if name not in VARIED:
                raise UsageError(f"--vary {name!r}: there are {', '.join(VARIED)}")


def varied_of(text: str | None, machine_file: Path) -> tuple[str, ...]:
    """Kinds named in a list such as `noise,payload`; None: the default of this machine.

    UsageError for a kind that needs a truth file where there is none.
    """
    truth = truth_file(machine_file)
    if text is None:
        return DEFAULT_VARIED if truth.exists() else OF_MODEL
    names = tuple(dict.fromkeys(word.strip() for word in text.split(",") if word.strip()))
    beyond = [name for name in names if name in VARIED and name not in OF_MODEL]
    if beyond and not truth.exists():
        raise UsageError(
            f"--vary {','.join(beyond)}: {machine_file.name} has no truth file {truth.name}, so the"
            f" simulated machine is its model, of which {', '.join(OF_MODEL)} can vary"
        )
    return names


def draw(
    plan: StudyPlan, number: int, machine: Machine, truth: Truth | None
) -> tuple[Values, Mapping[str, float]]:
    """Parameters of run `number`, and the few of them that are shown.

    Every kind has random numbers of its own: varying one more leaves the others as they are.
    """

    def dice(what: str) -> random.Random:
        return random.Random(f"{plan.seed}:{number}:{what}")

    values: dict[str, float | tuple[float, ...]] = {}
    shown: dict[str, float] = {}
    if "noise" in plan.varied:
        values["plant.seed"] = shown["noise"] = float(dice("noise").randrange(2**53))
    if "payload" in plan.varied:
        mass = shown["payload"] = dice("payload").uniform(0, plan.payload)
        values["reference.payload_count"] = 1.0
        values |= {"reference.payload_time[1]": 0.0, "reference.payload_mass[1]": mass}
    if "age" in plan.varied:
        values["plant.age"] = shown["age"] = dice("age").uniform(0, plan.age)
    if truth and "drift" in plan.varied:
        values |= _redrawn(machine, truth, dice("drift").randrange(2**53), ("drift_torque",))
    if truth and "truth" in plan.varied:
        values |= _redrawn(machine, truth, dice("truth").randrange(2**53), BUILT)
    if "trajectory" in plan.varied:
        values["reference.seed"] = shown["trajectory"] = float(dice("trajectory").randrange(2**53))
    return values, shown


@lru_cache(maxsize=8)
def start_values(machine: Machine, truth: Truth) -> dict[str, tuple[float, ...]]:
    """Start values of machine.fmu by name, as its build draws them from a truth."""
    variables = interface(machine, truth).variables
    return {v.name: tuple(float(x) for x in v.starts) for v in variables}


def _redrawn(
    machine: Machine, truth: Truth, seed: int, names: Sequence[str]
) -> dict[str, tuple[float, ...]]:
    """Parameters of another machine of the same make."""
    drawn = start_values(machine, truth.model_copy(update={"seed": seed}))
    return {f"plant.{name}": drawn[name] for name in names}

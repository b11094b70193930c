"""How old a signal is when it is used, computed from the schedule.

A component with the period N (base steps) samples its inputs at n = k N; what it computes
from them is seen by others from n + N on. Walking that rule backwards along a chain of
components tells which instant of the first one a value at the last one stems from.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from flexhex.fmus.common.errors import InterfaceError
from flexhex.ssp.hexapod import TORQUE_PATH
from flexhex.ssp.system import System


class DriveLags(Protocol):
    """What the delay of the torque path needs of `machine.drive`: [Hz], [s], [s]."""

    @property
    def f_current(self) -> float: ...
    @property
    def t_command(self) -> float: ...
    @property
    def t_measurement(self) -> float: ...


@dataclass(frozen=True)
class PathDelay:
    """Ages [base steps] of what the last component of a path samples, tick by tick.

    ages[k] belongs to the k-th tick of one hyperperiod: n - (instant of the first
    component's output that the sampled value stems from). period: of the last component.
    """

    path: tuple[str, ...]
    ages: tuple[int, ...]
    period: int

    @property
    def shortest(self) -> int:
        """Age of the freshest sample [base steps]."""
        return min(self.ages)

    @property
    def longest(self) -> int:
        """Age of the oldest sample [base steps]."""
        return max(self.ages)

    @property
    def mean(self) -> float:
        """Mean age while the samples act [base steps]: each is held for one period."""
        return sum(self.ages) / len(self.ages) + self.period / 2

    @property
    def sampled(self) -> int:
        """The one age of all samples [base steps]; InterfaceError when it varies."""
        if self.shortest != self.longest:
            raise InterfaceError(
                f"path {' -> '.join(self.path)}: the age of a sample varies between"
                f" {self.shortest} and {self.longest} base steps; choose sample times that"
                " divide one another"
            )
        return self.shortest


def path_delay(system: System, path: Sequence[str]) -> PathDelay:
    """Ages along a chain of connected components, such as ("reference", "N_F", "F").

    Raises InterfaceError when the path is shorter than two or not connected that way.
    """
    if len(path) < 2:
        raise InterfaceError("a path has at least two components")
    periods = [system.steps(name) for name in path]
    linked = {(wire.source, wire.target) for wire in system.wires}
    for pair in itertools.pairwise(path):
        if pair not in linked:
            raise InterfaceError(f"path {' -> '.join(path)}: {pair[0]} feeds no {pair[1]}")
    hyperperiod, last = math.lcm(*periods), periods[-1]
    # Far enough from the start that every walk ends at an instant n >= 0.
    first = hyperperiod * (1 + 2 * sum(periods) // hyperperiod)
    ticks = range(first, first + hyperperiod, last)
    ages = tuple(n - _origin(n, periods) for n in ticks)
    return PathDelay(tuple(path), ages, last)


def _origin(n: int, periods: Sequence[int]) -> int:
    """Instant of the first component's output from which a sample taken at n stems."""
    for period in reversed(periods[1:-1]):
        n = (n // period) * period - period
    return (n // periods[0]) * periods[0]


def reference_delay(system: System, drive: DriveLags) -> float:
    """Delay of r in the feedback, fractional [base steps]; z^-6 of [SH, Fig. 3].

    The mean age of the feedforward torque while it acts (5 base steps plus half the hold
    of 2 for the default sample times), what the drive adds to torque and angle, and the
    age of the angle, less the age that r has anyway when the feedback samples it.
    """
    lag = 1 / (2 * math.pi * drive.f_current) + drive.t_command + drive.t_measurement
    torque = path_delay(system, TORQUE_PATH).mean
    theta = path_delay(system, ("plant", "feedback")).sampled
    r = path_delay(system, ("reference", "feedback")).sampled
    return torque + theta - r + lag / system.base


def alignment(system: System) -> int:
    """Samples of W by which tau_f and chi_f must wait for N_E: all that the estimator
    sees is then of one instant.

    Both paths begin with outputs of W, so the difference is a whole number of its samples.
    Raises InterfaceError when it differs from tick to tick of the estimator.
    """
    late = path_delay(system, ("W", "N_E", "K")).sampled
    direct = path_delay(system, ("W", "K")).sampled
    return (late - direct) // system.steps("W")

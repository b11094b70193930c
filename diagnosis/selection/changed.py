"""Base parameters that are others than in the machine file."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.selection.criteria import Criteria

Array = NDArray[np.float64]
Axis = int | None
AGAIN = 1.0
"""One standard deviation of the mass of a body that may be another one, relative to the file's."""


@dataclass(frozen=True)
class ChangedParameter:
    """Base parameters, at these places, that may leave their tolerances: one, or a body's. Others
    could make all of its torque, if no tolerance held them: so all of it is its size."""

    id: str
    places: tuple[int, ...]
    axis: Axis
    extends: str = ""
    choices: int = 1
    varied: bool = False

    @property
    def ways(self) -> Array:
        """Directions (len(places), k) in which they may leave their tolerances."""
        return np.eye(len(self.places))

    def deviation(self, criteria: Criteria) -> float:
        """How far they may, one standard deviation of each direction."""
        return criteria.loose

    def possible(self, gains: Array) -> bool:
        """Whether a machine can have these gains (k,) of the directions."""
        return True

    @property
    def freedom(self) -> int:
        """A parameter that is there already is simpler than any effect."""
        return len(self.places) - 1


@dataclass(frozen=True, eq=False)
class HeavierBody(ChangedParameter):
    """A body with another mass, and all that goes with it; direction (len(places),): coefficients
    of as much again as the machine file says."""

    direction: Array = field(default_factory=lambda: np.zeros(0))

    @property
    def ways(self) -> Array:
        """All in step."""
        return self.direction[:, None]

    def deviation(self, criteria: Criteria) -> float:
        """Nothing, or twice what the file says."""
        return AGAIN

    def possible(self, gains: Array) -> bool:
        """A body has a mass."""
        return bool(gains[0] > -1.0)

    @property
    def freedom(self) -> int:
        """One number is another, as of a parameter."""
        return 0


@dataclass(frozen=True, eq=False)
class WrongFile(ChangedParameter):
    """All values of the machine file off by more than their tolerances; times: by so many, as a
    standard deviation."""

    times: float = 1.0

    def deviation(self, criteria: Criteria) -> float:
        """As far as a fit finds them off."""
        return self.times

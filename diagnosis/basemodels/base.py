"""What the diagnosis must know of a machine, and no more: columns that are linear in parameters.

    tau = B(motion) p + curved terms,  B (samples, n, n_p)

A base model may have terms with one nonlinear parameter each (the width of a hysteresis): their
values and derivatives are asked for apart, so that the nonlinear ones can be fitted as well.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from flexhex.diagnosis.reversals import Held, held, hysteresis_filter, turning
from flexhex.fmus.common.machine.effect_use import EffectUse
from flexhex.numeric.prediction import Continued

Array = NDArray[np.float64]
POWER = {"kg": 0, "kg m": 1, "kg m2": 2}
"""Powers of the reach in inertial parameters, by their unit."""
MEANS = 2048
"""Means of a run's accelerations that tell what came before it, at most. With half as many a mode
at 20 Hz is found at 28 in one of two draws of `test_calmest.py`; with a quarter one at 9 Hz is 6 to
10 % too fast where the motion is quiet."""


@dataclass(frozen=True)
class Motion:
    """One run's joints on one clock: t0 [s], ts [s]; theta, thetad, thetadd (samples, n): angles or
    positions.

    noise: standard deviation (n,) [rad] of the angles' white noise; None: they have none.
    derived: rates and accelerations are differences of the angles, so their noise is in them.
    solved: coordinates that follow from the angles alone, of each closure that has solved for them.
    """

    t0: float
    ts: float
    theta: Array
    thetad: Array
    thetadd: Array
    noise: Array | None = field(default=None, kw_only=True)
    derived: bool = field(default=False, kw_only=True)
    solved: dict[object, Array] = field(default_factory=dict, init=False, compare=False)

    @cached_property
    def steady(self) -> Array:
        """Angles (samples, n) without the way that noise goes."""
        return self.theta if self.noise is None else hysteresis_filter(self.theta, self.noise)

    @cached_property
    def turning(self) -> Array:
        """How much later than its sample each angle turned (samples, n), in samples."""
        return turning(self.theta, self._noise)

    @cached_property
    def held(self) -> list[Held]:
        """Samples in which each angle shows nothing of its turn."""
        return held(self.theta, self._noise)

    @cached_property
    def continued(self) -> Continued:
        """Accelerations before and after the run, by those along it."""
        return Continued.of(self.thetadd, MEANS)

    @property
    def _noise(self) -> Array:
        return np.zeros(self.theta.shape[1]) if self.noise is None else self.noise

    @property
    def time(self) -> Array:
        """Instants (samples,) [s]."""
        return np.asarray(self.t0 + self.ts * np.arange(len(self.theta)))


@dataclass(frozen=True)
class Known:
    """A parameter of the base model: its nominal value and how well that is known.

    tolerance: one standard deviation by which such a value may differ from the machine file
    without being worth a word; 0: fixed, infinite: free. group: what changes together (a body, a
    kind of flexure). axis: of the actuator that it belongs to, counting from 0, or None. file: the
    machine file's value, where the runs show that its body has another mass; wider: times its
    tolerance that it may then be off. bounded: no machine has it below zero, whatever its unit.
    shown: the unit in which it is printed, where torques are known as voltages alone.
    """

    name: str
    unit: str
    nominal: float
    tolerance: float
    group: str
    axis: int | None = None
    file: float | None = None
    wider: float = 1.0
    bounded: bool = False
    shown: str = ""

    @property
    def printed(self) -> str:
        """The unit in which its values are printed."""
        return self.shown or self.unit

    @property
    def written(self) -> float:
        """The value of the machine file."""
        return self.nominal if self.file is None else self.file

    @property
    def positive(self) -> bool:
        """Whether no machine has it at or below zero: a mass, a moment of inertia about an axis, a
        damping. (Those of an axis by itself are of all that moves it, and free.)"""
        kind = self.name.rpartition(".")[2].partition("[")[0]
        turning = self.unit == "kg m2" and kind in MOMENTS
        return self.nominal > 0 and (turning or self.unit in ("kg", "N m s/rad", "N s/m"))


MOMENTS = ("J", "J_xx", "J_yy", "J_zz", "J_r")
"""Names of moments of inertia about an axis; the others are products."""
LATE = 2.5
"""Samples of the log by which all torques together may stand behind the angles, or before them:
cycles of a controller, of a bus and of a logger. One tolerance."""


@dataclass(frozen=True)
class Stated:
    """Effects that the file of a base model states; tolerance: one standard deviation of their
    gains, relative, that is not worth a word."""

    uses: tuple[EffectUse, ...] = ()
    tolerance: float = 0.0


@runtime_checkable
class Standing(Protocol):
    """What a base model that knows how its machine stands can say of another way."""

    @property
    def gravity(self) -> Array:
        """(3,) [m/s2] in the frame of the foot."""
        ...

    def weights(self, motion: Motion, p: Array) -> Array:
        """Torques (samples, n, 3) at linear parameters p for gravity of 1 m/s2 along each axis of
        the foot."""
        ...


class Geometry(Protocol):
    """What errors of a machine's geometry do to its torques."""

    @property
    def known(self) -> tuple[Known, ...]:
        """The errors, nominally zero."""
        ...

    def columns(self, motion: Motion, weights: csr_array, p: Array) -> Array:
        """Smoothed torque (rows, n, len(known)) for a unit of each, at linear parameters p
        (n_p,); weights (rows, samples)."""
        ...


class Base(Protocol):
    """A machine's own model for the diagnosis.

    Its axes turn, unless it has `kinds` (`flexhex.diagnosis.kinds.kinds_of`). What is said here to
    be in rad or N m is in m or N for an axis that slides.
    """

    n: int
    """Axes."""
    linear: tuple[Known, ...]
    """Parameters of `rows`, in its order."""
    curved: tuple[Known, ...]
    """Gains of the curved terms, one for each axis, or nothing."""
    widths: tuple[Known, ...]
    """Their nonlinear parameters, likewise."""
    geometry: Geometry | None
    """Errors of its geometry, or None where it has none."""
    window: float
    """Length of the smoothing window [s]."""
    spacing: float
    """Time between two rows [s]."""
    settle: float
    """What is left out at the start of a run [s]."""
    late: float
    """Tolerance of the delay of all reported torques together [samples of the log]."""
    holds: frozenset[str]
    """Ids of effects that the base model has terms for already: no candidates."""
    given: tuple[EffectUse, ...]
    """Effects that the model has already, at the values of its file."""
    stated: Stated
    """Effects that the runs are asked for as for all others, and that are no finding where they
    come out as the file has them."""
    payload: tuple[int, ...]
    """Places in `linear` of the parameters that a payload changes."""
    rotors: tuple[int, ...]
    """Places in `linear` of the inertia of each axis' rotor, apart from what its gear drives; empty
    where they are one body."""
    reach: float
    """How far from its nominal place an announced payload may be [m]; infinite: nothing of it is
    known, whatever the logs say."""
    complete: bool
    """Whether it should explain most of the torque before any effect is added."""

    def loaded(self, p: Array, payload: float) -> Array:
        """The linear parameters with a known payload [kg]."""
        ...

    def rows(self, motion: Motion, weights: csr_array) -> Array:
        """Smoothed columns (rows, n, len(linear)); weights (rows, samples)."""
        ...

    def bend(self, motion: Motion, widths: Array) -> tuple[Array, Array]:
        """Curved terms (samples, n) for a gain of one, and their derivatives by the widths."""
        ...

    def torque(self, motion: Motion, p: Array) -> Array:
        """Linear part B p (samples, n) [N m] at every sample; p (len(linear),)."""
        ...

    def whole(self, motion: Motion, p: Array) -> Mapping[str, Array]:
        """Columns (samples, n, k) of effects that act on the whole mechanism, by their id."""
        ...

"""An effect: its parameters, states and torque columns, and how it is distinguished from others.

    tau_meas = Phi p + sum_j gain_j column_j

holds for effects on the torque and for those of the drive. One object of a subclass of
`Effect` is one effect; docs/decisions/0006-effects.md gives the reasons for this structure.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import product
from typing import Any, Literal

import casadi as ca

from flexhex.fmus.common.effects.experiment import Experiment as Experiment

Geared = Literal["", "torque", "angle"]
ActsOn = Literal["torque", "drive", "measurement", "mechanism"]
Line = Literal["", "lag", "delay"]
Expr = Any
"""A casadi.SX; CasADi's operators are not typed."""
Shapes = Mapping[str, Any]
"""Value of every shape by name: floats, or casadi.SX where they are searched."""


@dataclass(frozen=True)
class Gain:
    """A linear parameter [unit]; zero means that the effect is absent.

    typical: a size worth noticing, also the scale below which it counts as zero; below: another
    gain of the effect and how many times that it is at most, in the same unit or, with `of`, times
    the axis' largest torque or the inertia that it moves; full: at `high` the effect is there in
    full, which says no more than its name.
    """

    name: str
    unit: str
    typical: float
    low: float = -math.inf
    high: float = math.inf
    description: str = ""
    below: tuple[str, float] | None = None
    of: Literal["", "torque", "inertia"] = ""
    full: bool = False


@dataclass(frozen=True)
class Shape:
    """A nonlinear parameter [unit]: fixed in a machine file, searched by the diagnosis.

    start: first guess; grid: values to try; whole: only whole numbers make sense; closed: what
    seems to lie at `high` or beyond is something else; of_peak: the diagnosis takes all these
    numbers as shares of the largest torque; of_time: in proportion to the time that it sees; as_is:
    it takes them as they stand, for any axis; of_place: it counts them from where the axis moves on
    average; blended: real ones have several values at once, and this is the main one; optional: a
    machine file may leave it out, which means `start`; words: what numbers from `low` on mean;
    aside: the diagnosis needs it to fit the effect: it is neither reported nor in a machine file;
    open: a value of `high` may be any higher one.
    """

    name: str
    unit: str
    low: float
    high: float
    start: float
    grid: tuple[float, ...] = ()
    description: str = ""
    whole: bool = False
    closed: bool = False
    of_peak: bool = False
    of_time: bool = False
    as_is: bool = False
    of_place: bool = False
    blended: bool = False
    optional: bool = False
    words: tuple[str, ...] = ()
    aside: bool = False
    open: bool = False

    def said(self, value: float) -> str:
        """A value in words, where it has any."""
        place = round(value - self.low)
        return self.words[place] if 0 <= place < len(self.words) else ""


@dataclass(frozen=True)
class State:
    """A quantity [unit] that an effect remembers."""

    name: str
    unit: str


@dataclass(frozen=True)
class Signals:
    """What one axis does at one instant, each a scalar casadi.SX.

    theta, thetad, thetadd: the joint [rad, ...]; tau: motor torque as the drive reports it
    [N m]; taud: its rate [N m/s]; time: since the start of the run [s]; others: all axes of
    the machine in order, this one too; empty for a single axis.
    """

    theta: Any
    thetad: Any
    thetadd: Any
    tau: Any
    taud: Any
    time: Any
    others: tuple[Signals, ...] = ()

    @staticmethod
    def resting(theta: Any) -> Signals:
        """At an angle, without motion or torque."""
        still = ca.SX(0)
        return Signals(theta, still, still, still, still, still)

    def towards(self, now: Signals, share: float) -> Signals:
        """The instant `share` (0..1) of the way to `now`, by straight lines."""
        names = ("theta", "thetad", "thetadd", "tau", "taud", "time")
        mixed = {k: (1 - share) * getattr(self, k) + share * getattr(now, k) for k in names}
        pairs = zip(self.others, now.others, strict=True)
        return replace(self, **mixed, others=tuple(a.towards(b, share) for a, b in pairs))


class Effect:
    """One effect; a subclass sets the attributes and overrides what it needs.

    aside     gains that the diagnosis fits together with `gains`, to tell the effect from what goes
              with it; neither reported nor in a machine file
    acts_on   torque: the joint needs sum gain column more [N m]
              drive: the drive reports sum gain column more than the joint gets [N m]
              measurement: the encoder reads sum gain column more than the angle [rad]
              mechanism: no columns, `mechanism` changes the model
    line      how the plant delays a drive's torque exactly, where columns are a first order
    feedforward  "" where the feedforward compensates it, else the reason why not
    loses     whether its gain is the share of the reported torque that the joint does not get
    reported  whether it can also act between the commanded and the reported torque, where
              the torque constant has no influence
    entered   whether its torque is the one that enters the drive and is reported: what the joint
              needs never goes beyond a limit
    behind    the part of such an effect that acts after the reported torque; None: all of it
    size      parameter that says how large it is; "": its gains
    extends   id of the effect this becomes when all gains but the first are zero
    imitates  id of the effect that wide values of its shapes imitate: they are chosen beside that
              one
    limit     id of the effect this comes to at an end of its shape's range: a rival of that one
              only where it predicts better
    most      how many of it, with other shapes, one axis can have
    turning   whether only an axis that turns can have it
    geared    what an error between a rotor, whose angle is read, and the link that it drives goes
              with: the torque that passes on to the link, or the angle; "": it does not lie there
    exact     the functional form is physically exact (a sine, say), so no allowance for model
              error is made when it is compared with another exact effect
    varied    real ones differ from the form by a good part, with load, temperature, place: more may
              be left beside one that has its name
    origin    where a user's own one is from, as a machine file calls it; "": the library's
    usual     size, relative to the torque's RMS, that every machine may have of it: no finding
    """

    id: str
    title: str
    acts_on: ActsOn
    gains: tuple[Gain, ...]
    aside: tuple[Gain, ...] = ()
    shapes: tuple[Shape, ...] = ()
    states: tuple[State, ...] = ()
    line: Line = ""
    loses: bool = False
    excites: str
    confused_with: tuple[str, ...] = ()
    experiment: str
    spec: Experiment
    feedforward: str = ""
    reported: bool = False
    entered: bool = False
    behind: Effect | None = None
    size: str = ""
    extends: str = ""
    imitates: str = ""
    limit: str = ""
    most: int = 1
    turning: bool = False
    geared: Geared = ""
    exact: bool = False
    varied: bool = False
    usual: float = 0.0
    origin: str = ""

    @property
    def grid(self) -> list[dict[str, float]]:
        """Combinations of the shapes' values that are tried."""
        names = [shape.name for shape in self.shapes]
        grids = [shape.grid or (shape.start,) for shape in self.shapes]
        return [dict(zip(names, values, strict=True)) for values in product(*grids)]

    @property
    def fitted(self) -> tuple[Gain, ...]:
        """All gains that the diagnosis fits: `gains`, then `aside`."""
        return (*self.gains, *self.aside)

    def columns(self, s: Signals, state: ca.SX, shape: Shapes) -> Expr:
        """Torque [N m] or angle [rad] per unit of each gain (n_gains,)."""
        raise NotImplementedError(f"{self.id} has no columns")

    def aside_columns(self, s: Signals, shape: Shapes) -> Expr:
        """The same, per unit of each gain of `aside` (n_aside,)."""
        return ca.SX(0, 1)

    def rate(self, s: Signals, state: ca.SX, shape: Shapes) -> Expr:
        """d state / dt (n_states,); no thetadd in it."""
        return ca.SX(0, 1)

    def advance(self, before: Signals, now: Signals, state: ca.SX, shape: Shapes, Ts: Any) -> Expr:
        """The state (n_states,) at `now`, Ts [s] after `before`.

        Override it where an exact form exists; this is one Runge-Kutta step of `rate`.
        """
        if not self.states:
            return state
        middle = before.towards(now, 0.5)
        k1 = self.rate(before, state, shape)
        k2 = self.rate(middle, state + Ts / 2 * k1, shape)
        k3 = self.rate(middle, state + Ts / 2 * k2, shape)
        k4 = self.rate(now, state + Ts * k3, shape)
        return state + Ts / 6 * (k1 + 2 * (k2 + k3) + k4)

    def meets(self, axis: int, n: int, shape: Mapping[str, float]) -> bool:
        """Whether these shapes mean this effect on an axis (from 1) of n axes."""
        return True

    def start(self, s: Signals, shape: Shapes) -> Expr:
        """The state (n_states,) of a motion that has long gone on as in these signals."""
        return ca.SX.zeros(len(self.states))

    def meaning(self, values: Mapping[str, float], units: Mapping[str, str]) -> str:
        """What these gains of an axis, in these units, mean where their names do not say it."""
        return ""

    def mechanism(self, gravity: ca.SX, gains: Mapping[str, Any]) -> Expr:
        """Gravity (3,) [m/s2] that the machine feels, for acts_on = "mechanism"."""
        return gravity

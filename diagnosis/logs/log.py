"""What a log is once it has been read: channels on even clocks, and what was noticed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.kinds import Kinds
from flexhex.diagnosis.logs.motor import Motor
from flexhex.diagnosis.reversals import angle_noise
from flexhex.fmus.common.errors import LogError

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
MEMORY = 400e6
"""Bytes of samples that one log may take before stretches are left out."""
COARSE = 0.005
"""Sample time [s] at which runs are compared."""
POINTS = 20_000
"""Samples of a run that are compared at most: noise of 1e-3 of the motion, averaged over so many,
moves a shift by hundredths of a sample."""
MOVES = 8.0
"""Standard deviations of its noise beyond which a signal moves: noise is no motion."""


@dataclass(frozen=True)
class Channel:
    """Samples values (samples, width) in SI units; sample k stands at t0 + k ts [s].

    valid (samples,): False where the values were not measured (a filled gap, a NaN stretch) or
    are not the truth (clipped). Invalid values are finite: a straight line between the good
    neighbours. breaks: (index, skipped): from sample `index` on, time is `skipped` [s] later
    than even spacing says, because a long gap or a left-out stretch stands before it; the
    sample before `index` is invalid, so whatever leaves out windows that touch an invalid
    sample never looks across a break.
    """

    t0: float
    ts: float
    values: Array
    valid: Mask
    breaks: tuple[tuple[int, float], ...] = ()

    @property
    def time(self) -> Array:
        """Time of each sample (samples,) [s] on the clock of the file."""
        time = self.t0 + self.ts * np.arange(len(self.values))
        for index, skipped in self.breaks:
            time[index:] += skipped
        return np.asarray(time)

    @cached_property
    def coarse(self) -> Array:
        """Samples every COARSE s from t0 on, mean removed (samples, width); zeros where nothing
        moves."""
        time = self.time
        grid = np.arange(time[0], time[-1] + 0.5 * self.ts, COARSE)
        values = np.column_stack([np.interp(grid, time, column) for column in self.values.T])
        values -= values.mean(axis=0)
        size, first = np.abs(values).max(axis=0), self.values[:POINTS]
        # mostly that which moves most tells it
        order = np.argsort(-size).tolist()
        moves = any(size[i] > MOVES * angle_noise(first[:, i : i + 1])[0] for i in order)
        return values if moves else np.zeros_like(values)

    @property
    def width(self) -> int:
        """Number of axes, 1 for a scalar channel."""
        return int(self.values.shape[1])


@dataclass(frozen=True)
class Finding:
    """Something noticed while reading.

    kind: "bad-rows", "break", "clipped", "clock", "constant", "conversion", "cycles", "delay",
    "drift", "duplicate", "extra", "gap", "held", "held-out", "jitter", "jump", "memory",
    "metadata", "missing", "names", "nan", "no-repeat", "passes", "range", "rate", "rates", "reset",
    "short", "sign", "spike", "swapped", "units", "wrapped". where: file and channel. corrected:
    whether the log is as good as if it had not been there.
    """

    kind: str
    where: str
    text: str
    corrected: bool

    def __str__(self) -> str:
        return f"{self.where}: {self.text}"


@dataclass(frozen=True)
class Options:
    """What the user adds to a log: torque_constant [N m/A, N/A], one or one for each axis; units by
    channel (`{"theta": "deg"}`, or for each axis: `"rad, mm"`) whose file states none; `"deg not
    rad"` takes the place of what the file states; rename: {name in the file: channel}; memory:
    bytes of samples to keep; motor: data of the motors of a log in V."""

    torque_constant: float | tuple[float, ...] | None = None
    units: Mapping[str, str] = field(default_factory=dict)
    rename: Mapping[str, str] = field(default_factory=dict)
    memory: float = MEMORY
    motor: Motor | None = None


@dataclass(frozen=True)
class Log:
    """One run. channels: by name (`theta`, `tau_meas`, `r` ...); meta: what the file says; kinds:
    of the axes, none where all turn. What has the unit rad or N m for an axis that turns is in m or
    N for one that slides.

    shift [s]: time - shift is common to the passes of a trajectory; `group_runs` sets it. unused:
    channels of rates or accelerations that are no better than differences of the angles.
    """

    name: str
    channels: Mapping[str, Channel]
    meta: Mapping[str, str] = field(default_factory=dict)
    findings: tuple[Finding, ...] = ()
    shift: float = 0.0
    kinds: Kinds = ()
    unused: frozenset[str] = frozenset()

    @classmethod
    def of(cls, name: str, ts: float, theta: Array, tau: Array, kinds: Kinds = ()) -> Log:
        """A log of samples at hand: theta, tau (samples, n) [rad], [N m] every ts [s]."""
        channels = {
            key: Channel(0.0, ts, values, np.ones(len(values), dtype=bool))
            for key, values in (("theta", theta), ("tau_meas", tau))
        }
        return cls(name, channels, kinds=kinds)

    def __getitem__(self, name: str) -> Channel:
        if name not in self.channels:
            raise LogError(f"{self.name}: no channel `{name}`; it has {', '.join(self.channels)}")
        return self.channels[name]

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the joints in the order of the axes, where the file tells them."""
        return tuple(filter(None, self.meta.get("joints", "").split(",")))

    def refuse_width(self, n: int, remedy: str = "is it of the machine that is modelled?") -> None:
        """LogError where the log has another number of axes than a model's n; remedy: what is
        asked then."""
        for name in ("theta", "tau_meas"):
            if (axes := self[name].width) != n:
                width = f"{axes} {'axis' if axes == 1 else 'axes'}"
                raise LogError(f"{self.name}: {name} has {width}, the model has {n}: {remedy}")

    @property
    def theta(self) -> Array:
        """Angles (samples, n) [rad]."""
        return self["theta"].values

    @property
    def tau(self) -> Array:
        """Measured torques (samples, n) [N m]; on their own clock, see `same_clock`."""
        return self["tau_meas"].values

    @property
    def ts(self) -> float:
        """Sample time of the angles [s]."""
        return self["theta"].ts

    @property
    def same_clock(self) -> bool:
        """Whether angles and torques are sampled at the same instants."""
        a, b = self["theta"], self["tau_meas"]
        same = (a.t0, a.ts, a.breaks, len(a.values)) == (b.t0, b.ts, b.breaks, len(b.values))
        return bool(same)

    @property
    def trajectory(self) -> str:
        """Name of the trajectory, "" when the file does not tell."""
        return self.meta.get("trajectory", "")

    @property
    def pass_number(self) -> int | None:
        """Number of the pass, None when the file does not tell."""
        try:
            return int(float(self.meta["pass"]))
        except (KeyError, ValueError, OverflowError):
            return None

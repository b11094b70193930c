"""What a machine can do, and whether a motion stays within it, everywhere between its rows."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.closure import Closure
from flexhex.fmugen.codegen import SYMBOLIC
from flexhex.fmus.common.errors import TrajectoryError
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.model.geometry import AXES
from flexhex.fmus.common.model.model import Model
from flexhex.fmus.player import equations as player
from flexhex.fmus.player.table import Table
from flexhex.fmus.pose import equations as pose
from flexhex.fmus.pose.interface import MARGIN
from flexhex.numeric.rows import RowFunction, native
from flexhex.trajectory.file import Rows

Array = NDArray[np.float64]
REST = 1e-6
"""Largest difference from the rest at neutral [rad, m, 1; per s, per s2]: a twentieth of what the
adaptive feedforward leaves over."""
SWING = 0.25
"""How far a motion may swing beyond two neighbouring rows where the file gives values alone, as a
share of the whole range: splines through even waypoints stay below 0.16, through rows with a long
gap before a short one they swing by more than the range, which nobody means."""
PLACES = (0.25, 0.5, 0.75)
"""Where between two rows that is looked for: a cubic is widest near the middle."""
CHUNK = 100_000
"""Instants that are looked at together, 25 s at 4 kHz: some 30 MB."""


def channel(rows: Rows, k: int) -> str:
    """What the value k of a row is called."""
    if rows.kind == "joints":
        return f"r[{k + 1}]"
    return f"x_E.{AXES[k]}" if k < 3 else "orientation"


@dataclass(frozen=True)
class Instants:
    """Part of a motion at the base step: time (m,) [s]; r, rd, rdd (m, n)."""

    time: Array
    r: Array
    rd: Array
    rdd: Array


class Limits:
    """What a machine can do, and whether a motion stays within it at every base step."""

    def __init__(self, machine: Machine, rows: Rows, table: Table) -> None:
        self.machine, self.rows, self.table = machine, rows, table
        with SYMBOLIC:
            self.between = _compiled(player.functions(machine, table.kind)[0])
            self.solve = _compiled(pose.functions(machine)[0]) if machine.has_platform else None
            closes = machine.has_platform and table.kind == "joints"
            self.closure = Closure(Model(machine)) if closes else None

    def check_swing(self) -> None:
        """TrajectoryError where the interpolation leaves the range of its two rows by far."""
        time, n = self.table.time, self.table.rows.shape[1] // 3
        values = self.table.rows[:, :n]
        low, high = np.minimum(values[1:], values[:-1]), np.maximum(values[1:], values[:-1])
        allowed = SWING * np.ptp(values, axis=0) + REST
        for place in PLACES:
            at = time[:-1] + place * np.diff(time)
            between = self._motion(at)[:, :n]
            beyond = np.maximum(low - between, between - high)
            for k, value in _first(~(beyond <= allowed)):
                raise self._error(
                    at[k],
                    f"{channel(self.rows, value)} swings by {beyond[k, value]:.3g} beyond its"
                    " rows: the time between rows is too uneven; add rows, or columns of rates",
                )

    def check(self) -> None:
        """TrajectoryError for the first instant that the machine cannot reach."""
        base = self.machine.timing.base
        count = int(np.ceil(self.table.end / base - 1e-9)) + 1
        for begin in range(0, count, CHUNK):
            # two ticks that the next chunk has as well: accelerations are differences of three
            ticks = np.arange(begin, min(begin + CHUNK + 2, count))
            time = np.minimum(ticks * base, self.table.end)
            motion = self._motion(time)
            if self.table.kind == "joints":
                n = self.machine.n_arms
                instants = Instants(time, *(motion[:, k * n : (k + 1) * n] for k in range(3)))
            else:
                instants = self._solved(time, motion)
            self._check(instants)

    def _motion(self, time: Array) -> Array:
        """Values, rates and accelerations (m, 3 n) at times (m,)."""
        at, rows = self.table.time, self.table.rows
        k = np.clip(np.searchsorted(at, time, side="right") - 1, 0, len(at) - 2)
        since, apart = (time - at[k])[:, None], (at[k + 1] - at[k])[:, None]
        (motion,) = self.between(since, apart, rows[k], rows[k + 1])
        return motion

    def _poses(self, motion: Array) -> list[Array]:
        """r, rd, rdd, margin (m, n) of poses with rates (m, 21)."""
        assert self.solve is not None
        parts = np.split(motion, [3, 7, 10, 14, 17], axis=1)
        return self.solve(*parts)

    def _solved(self, time: Array, motion: Array) -> Instants:
        r, rd, rdd, margin = self._poses(motion)
        for k, arm in _first(~(margin >= MARGIN)):
            raise self._error(time[k], f"the pose is out of reach of arm {arm + 1}")
        return Instants(time, r, rd, rdd)

    def _check(self, at: Instants) -> None:
        stroke = self.machine.geometry.stroke
        for k, joint in _first(~(np.abs(at.r) <= stroke)):
            raise self._error(
                at.time[k],
                f"joint {joint + 1} leaves its stroke: {at.r[k, joint]:.6g} rad, allowed"
                f" {-stroke:.6g} to {stroke:.6g} rad",
            )
        control, drive = self.machine.control, self.machine.drive
        most = drive.tau_max / control.J_design
        # a jump between two ticks shows in the angles alone
        accelerations = np.abs(at.rdd)
        between = np.abs(np.diff(at.r, 2, axis=0)) / self.machine.timing.base**2
        accelerations[1:-1] = np.maximum(accelerations[1:-1], between)
        for k, joint in _first(~(accelerations <= most)):
            raise self._error(
                at.time[k],
                f"a jump, or too fast: joint {joint + 1} accelerates by"
                f" {accelerations[k, joint]:.4g} rad/s2, its motor reaches about {most:.4g}",
            )
        if self.closure is not None:
            x = self.closure.solve(at.r)
            poses = np.hstack([x[:, -7:], np.zeros((len(x), 14))])
            back = self._poses(poses)[0]
            for k, _ in _first(~(np.abs(back - at.r) <= REST)):
                raise self._error(at.time[k], "no pose of the end-effector has these six angles")

    def _error(self, time: float, text: str) -> TrajectoryError:
        """An error about an instant, which names the lines around it."""
        lines, at = self.rows.lines, self.table.time
        k = min(int(np.searchsorted(at, time, side="right")) - 1, len(at) - 2)
        when = f"t = {time + self.rows.time[0]:.9g} s"
        return TrajectoryError(
            f"{self.rows.path}: lines {lines[k]} to {lines[k + 1]}, {when}: {text}"
        )


def _compiled(function: ca.Function) -> RowFunction:
    """A function of an FMU's equations, compiled for rows."""
    inputs = function.sx_in()
    names = function.name_in(), function.name_out()
    name = f"native_{function.name()}"
    return native([ca.Function(name, inputs, function.call(inputs), *names)])[0]


def _first(wrong: NDArray[np.bool_]) -> Iterator[tuple[int, int]]:
    """Row and column of the first that is wrong, if any."""
    places = np.argwhere(wrong)
    if len(places):
        yield int(places[0, 0]), int(places[0, 1])

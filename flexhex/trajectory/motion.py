"""A trajectory file as a motion of one machine: complete, from rest to rest, within its limits."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.closure import Closure
from flexhex.fmugen.codegen import SYMBOLIC
from flexhex.fmus.common.errors import TrajectoryError
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.model.model import Model
from flexhex.fmus.common.model.quaternion import of_rotation_vector
from flexhex.fmus.player import equations as player
from flexhex.fmus.player.table import Table
from flexhex.fmus.pose import equations as pose
from flexhex.fmus.pose.interface import MARGIN
from flexhex.numeric.rows import RowFunction, native
from flexhex.trajectory.file import Rows, read_rows
from flexhex.trajectory.smooth import completed

Array = NDArray[np.float64]
UNIT = 1e-3
"""How far the length of a quaternion in a file may be from one: three decimals."""
REST = 1e-6
"""Largest difference from the rest at neutral [rad, m, 1; per s, per s2]: a hundredth of what the
feedback leaves over."""
CHUNK = 100_000
"""Instants that are looked at together, 25 s at 4 kHz: some 30 MB."""


def read_motion(path: Path, machine: Machine) -> Table:
    """The motion of a file, checked for a machine.

    Raises TrajectoryError for what the file holds or the machine cannot do, with line and time;
    MachineError for poses of a machine without a platform.
    """
    rows = read_rows(path)
    if rows.kind == "joints":
        parts, neutral = [rows.of["r"]], np.zeros(machine.n_arms)
    else:
        neutral = np.append(np.array(machine.platform.x_E0), [1.0, 0.0, 0.0, 0.0])
        turn = _quaternions(rows) if "lam" in rows.of else _turned(rows.of["phi"])
        parts = [rows.of["x"], _one_side(turn)]
    given = [np.hstack(derivatives) for derivatives in zip(*parts, strict=True)]
    _check_rest(rows, 0, "starts", given, neutral)
    _check_rest(rows, -1, "ends", given, None)
    motion = np.hstack(completed(rows.time, given))
    table = Table(rows.kind, rows.time - rows.time[0], motion, rows.payload)
    Limits(machine, rows, table).check()
    return table


def _quaternions(rows: Rows) -> list[Array]:
    length = np.linalg.norm(rows.of["lam"][0], axis=1)
    for k in np.flatnonzero(np.abs(length - 1) > UNIT)[:1]:
        raise rows.error(int(k), f"lam_E has the length {length[k]:.6g}, must be 1")
    return [part / length[:, None] for part in rows.of["lam"]]


def _turned(phi: Sequence[Array]) -> list[Array]:
    """lam_E and its derivatives from as many of the rotation vector."""
    symbols = [ca.SX.sym(f"phi{order}", 3) for order in range(3)]
    lam = of_rotation_vector(symbols[0])
    lamd = ca.jtimes(lam, symbols[0], symbols[1])
    both, rates = ca.vertcat(*symbols[:2]), ca.vertcat(*symbols[1:])
    whole = ca.vertcat(lam, lamd, ca.jtimes(lamd, both, rates))
    turned = ca.Function("turned", symbols, [whole])
    zeros = [np.zeros_like(phi[0])] * (3 - len(phi))
    values = np.array(turned(*(part.T for part in (*phi, *zeros)))).T
    return [values[:, 4 * k : 4 * k + 4] for k in range(len(phi))]


def _one_side(turn: list[Array]) -> list[Array]:
    """lam and -lam turn alike: each row on the side of the one before, the first on neutral's."""
    lam = turn[0]
    same = np.append(np.sign(lam[0, 0]), np.sign(np.sum(lam[1:] * lam[:-1], axis=1)))
    sign = np.cumprod(np.where(same < 0, -1.0, 1.0))[:, None]
    return [sign * part for part in turn]


def _check_rest(rows: Rows, row: int, what: str, given: list[Array], at: Array | None) -> None:
    """TrajectoryError unless the first or last row rests; at: where, None is anywhere."""
    names = ["r"] * 6 if rows.kind == "joints" else ["x_E"] * 3 + ["orientation"] * 4
    row %= len(rows.time)
    for order, values in enumerate(given):
        wanted = at if order == 0 else np.zeros(len(names))
        if wanted is None:
            continue
        off = np.abs(values[row] - wanted)
        k = int(np.argmax(off))
        if off[k] > REST:
            index = k if names[k] != "orientation" else k - 3
            quantity = f"{names[k]}[{index + 1}]" if names[k] != "orientation" else names[k]
            if order == 0:
                why = f"{quantity} is {off[k]:.3g} from the neutral pose, where the machine rests"
            else:
                why = f"the {('rate', 'acceleration')[order - 1]} of {quantity} is not zero"
            raise rows.error(row, f"the motion {what} with a jump: {why}; lead it there from rest")


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
    """A function of a room, compiled for rows."""
    inputs = function.sx_in()
    names = function.name_in(), function.name_out()
    name = f"native_{function.name()}"
    return native([ca.Function(name, inputs, function.call(inputs), *names)])[0]


def _first(wrong: NDArray[np.bool_]) -> Iterator[tuple[int, int]]:
    """Row and column of the first that is wrong, if any."""
    found = np.argwhere(wrong)
    if len(found):
        yield int(found[0, 0]), int(found[0, 1])

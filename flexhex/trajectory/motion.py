"""A trajectory file as a motion of one machine: complete, from rest to rest, within its limits."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.model.quaternion import of_rotation_vector
from flexhex.fmus.player.table import Table
from flexhex.trajectory.file import Rows, read_rows
from flexhex.trajectory.limits import REST, Limits, channel
from flexhex.trajectory.smooth import completed

Array = NDArray[np.float64]
UNIT = 1e-3
"""How far the length of a quaternion in a file may be from one: three decimals."""


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
    limits = Limits(machine, rows, table)
    if len(given) == 1:
        limits.check_swing()
    limits.check()
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
    row %= len(rows.time)
    for order, values in enumerate(given):
        wanted = at if order == 0 else np.zeros(values.shape[1])
        if wanted is None:
            continue
        off = np.abs(values[row] - wanted)
        k = int(np.argmax(off))
        if off[k] > REST:
            quantity = channel(rows, k)
            if order == 0:
                why = f"{quantity} is {off[k]:.3g} from the neutral pose, where the machine rests"
            else:
                why = f"the {('rate', 'acceleration')[order - 1]} of {quantity} is not zero"
            raise rows.error(row, f"the motion {what} with a jump: {why}; lead it there from rest")

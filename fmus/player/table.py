"""The motion that a player plays: rows of values, rates and accelerations, as C text."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from flexhex.fmus.common.machine.machine import Machine

Array = NDArray[np.float64]
Kind = Literal["joints", "pose"]
"""What a motion is of: the six reference angles, or position and quaternion of E."""
HEADER = "player_table.h"
"""The file of the FMU's sources that holds the motion."""


def channels(machine: Machine, kind: Kind) -> int:
    """Numbers that a motion of this kind has at an instant, without rates."""
    return machine.n_arms if kind == "joints" else 7


@dataclass(frozen=True)
class Table:
    """time (rows,) [s] from 0 on; rows (rows, 3 n): values, rates, accelerations of all n channels;
    payload (rows,) [kg]: each from its row's time on. At least two rows, the last at rest."""

    kind: Kind
    time: Array
    rows: Array
    payload: Array

    @property
    def end(self) -> float:
        """Time of the last row [s]."""
        return float(self.time[-1])


def header(table: Table) -> str:
    """Text of `player_table.h`; numbers as they read back exactly."""
    count, width = table.rows.shape
    rows = ",\n".join(f"  {{{_numbers(row)}}}" for row in table.rows)
    return "\n".join(
        [
            "/* The motion of a player, generated from a trajectory file. Do not edit. */",
            "#ifndef FLEXHEX_PLAYER_TABLE_H",
            "#define FLEXHEX_PLAYER_TABLE_H",
            f"enum {{ ROWS = {count}, WIDTH = {width} }};",
            f"static const double row_time[ROWS] = {{{_numbers(table.time)}}};",
            f"static const double row_payload[ROWS] = {{{_numbers(table.payload)}}};",
            f"static const double row[ROWS][WIDTH] = {{\n{rows}}};",
            "#endif",
            "",
        ]
    )


def _numbers(values: Array) -> str:
    return ", ".join(map(repr, values.tolist()))

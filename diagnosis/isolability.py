"""Which effects a planned experiment can tell apart, as data."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
ALIKE = 0.9
"""Share from which on two effects count as one that cannot be told apart."""


@dataclass(frozen=True)
class Isolability:
    """Effects by id and the axis they were tried on (from 1, empty: the whole machine).

    share (k, k): how much of one effect the other can take over, 1 = cannot be told apart, on the
    diagonal 1; smallest (k,) [N m]: torque RMS from which on an effect is found, NaN: never.
    """

    effects: tuple[str, ...]
    axes: tuple[tuple[int, ...], ...]
    share: Array
    smallest: Array

    def rivals(self, k: int, alike: float = ALIKE) -> list[int]:
        """Effects that cannot be told from effect k, the most alike first."""
        row = np.fmax(self.share[k], self.share[:, k])
        found = [j for j in np.argsort(-row, kind="stable") if j != k and row[j] >= alike]
        return [int(j) for j in found]

    def data(self) -> dict[str, Any]:
        """As in `--json`; a figure that is no number is null."""
        smallest = [float(v) if math.isfinite(v) else None for v in self.smallest]
        return {
            "effects": list(self.effects),
            "axes": [list(axes) for axes in self.axes],
            "share": [[float(v) if math.isfinite(v) else None for v in row] for row in self.share],
            "smallest": {"unit": "N m", "values": smallest},
        }

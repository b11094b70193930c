"""What a simulation of measured runs says, as data."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Model:
    """How far one model's angles are from the measured ones.

    rms (steps + 1, n): RMS over the windows so long after their start, NaN from where one has
    diverged; diverged: how many of them have; first [s]: after how long the first of these did, NaN
    where none did. line (samples, n): the angles in the drawn windows.
    """

    rms: Array
    diverged: int
    first: float
    line: Array = field(repr=False)


@dataclass(frozen=True)
class Simulation:
    """Windows of measured runs, each simulated from its measured state with the measured torques.

    units: of the positions (n,); horizons [s]: at which errors are told; dt [s]: step; windows: how
    many; constant: the rate at their start goes on; file: with the file's values, None where there
    is no such model; fitted: with the estimates. run, time (samples,), measured (samples, n): the
    windows of one run that are drawn, NaN between two. left_out: what of the estimates is no part
    of it; why: why there is no simulation with the file's values; bare: whether the file has
    neither friction nor effects.
    """

    units: tuple[str, ...]
    horizons: tuple[float, ...]
    dt: float
    windows: int
    held_out: bool
    constant: Model
    file: Model | None
    fitted: Model
    run: str
    time: Array = field(repr=False)
    measured: Array = field(repr=False)
    left_out: tuple[str, ...] = ()
    why: str = ""
    bare: bool = True

    @property
    def models(self) -> dict[str, Model]:
        """Those that there are, by their names in `--json`."""
        listed = {"constant_rate": self.constant, "file": self.file, "fitted": self.fitted}
        return {name: model for name, model in listed.items() if model is not None}

    def at(self, model: Model) -> Array:
        """RMS errors (horizons, n) of a model."""
        return model.rms[[round(one / self.dt) for one in self.horizons]]

    def data(self) -> dict[str, Any]:
        """As in `--json`; null where a window has diverged."""
        rms = {
            name: [[v if np.isfinite(v) else None for v in row] for row in self.at(model).tolist()]
            for name, model in self.models.items()
        }
        diverged = {
            name: {"windows": model.diverged, "first": model.first}
            for name, model in self.models.items()
            if model.diverged
        }
        return {
            "horizons": list(self.horizons),
            "units": list(self.units),
            "windows": self.windows,
            "held_out": self.held_out,
            "step": self.dt,
            "position_error_rms": rms,
            "diverged": diverged,
            "left_out": list(self.left_out),
        }

"""What an identification says, as data: for the terminal, files and `--json`."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.estimation.estimate import Estimated
from flexhex.diagnosis.estimation.forward.record import Simulation
from flexhex.diagnosis.result.estimates import Estimate, Parameter
from flexhex.diagnosis.result.pictured import Strip

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Errors:
    """RMS of what is left of the smoothed torque relative to its RMS (n,): with the file's
    parameters and effects, and with the estimates. torque (n,): RMS in the axes' units."""

    torque: Array
    file: Array
    fitted: Array

    def data(self) -> dict[str, Any]:
        """As in `--json`."""
        names = ("torque", "file", "fitted")
        return {
            str(i + 1): {name: float(getattr(self, name)[i]) for name in names}
            for i in range(len(self.torque))
        }


@dataclass(frozen=True)
class Identified:
    """What `flexhex identify` says of a base model.

    parameters: all; combinations: base parameters of the mechanism, which torques can tell at all;
    silent: names of what no torque feels. on: errors on the runs, and on held-out ones. notes:
    sentences for the reader; findings: what the logs had. estimated: the fit. doubt: why the model
    may not be this machine's. strips: torque over time of each axis, of the first held-out run,
    else of the first run: measured, `before` with the file's parameters and effects, `after`
    with the estimates. simulation: positions of the same runs from their torques, or None.
    """

    base: str
    parameters: tuple[Parameter, ...]
    combinations: tuple[Parameter, ...]
    silent: tuple[str, ...]
    units: tuple[str, ...]
    errors: Errors
    held_out: Errors | None
    delay: Estimate
    notes: tuple[str, ...]
    findings: tuple[str, ...]
    runs: tuple[str, ...]
    held_out_runs: tuple[str, ...]
    estimated: Estimated = field(repr=False)
    doubt: str = ""
    strips: tuple[Strip, ...] = field(default=(), repr=False)
    simulation: Simulation | None = field(default=None, repr=False)

    def __getitem__(self, name: str) -> Parameter:
        """A parameter by its name. KeyError where there is none."""
        for one in self.parameters:
            if one.name == name:
                return one
        raise KeyError(name)

    def data(self) -> dict[str, Any]:
        """As in `--json`."""
        forms = [
            {"axis": i + 1, "kind": form.kind, "size": form.size, "unit": form.unit,
             "lead": form.lead}
            for i, form in enumerate(self.estimated.forms)
        ]  # fmt: skip
        return {
            "base": self.base,
            "parameters": [one.data() for one in self.parameters],
            "combinations": [one.data() for one in self.combinations],
            "unobservable": list(self.silent),
            "delay": self.delay.data(),
            "friction_forms": forms,
            "relative_error": {
                "units_of_torque": list(self.units),
                "runs": self.errors.data(),
                "held_out": self.held_out.data() if self.held_out else None,
            },
            "simulation": self.simulation.data() if self.simulation else None,
            "doubt": self.doubt,
            "notes": list(self.notes),
            "findings": list(self.findings),
            "runs": list(self.runs),
            "held_out": list(self.held_out_runs),
        }

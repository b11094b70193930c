"""What a diagnosis says, as data: for the terminal, the report and `--json`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.result.confidence import Confidence
from flexhex.diagnosis.result.estimates import Estimate, Parameter, finite
from flexhex.diagnosis.result.pictured import Candidate, Map, Strip
from flexhex.diagnosis.result.rest import Rest

Array = NDArray[np.float64]
NORMAL = 1.96
"""Standard deviations to either end of a 95 % interval."""
MEND = "mend the log"
"""What is to be done before anything can be told."""
WORSE = 1.02
"""Growth of a residual from which on it counts as worse."""
LARGE = 0.2
"""Share of an axis' torque (RMS) that is left, from which something large is missing."""
VERDICTS = ("named", "ambiguous", "changed", "unknown", "none", "cannot tell")


@dataclass(frozen=True)
class Named:
    """An effect that was found: axes count from 1 and are empty where it acts on the whole.

    parameters: estimates by name, `name[axis]` where several axes have the effect and
    `name[axis]#2` where an axis has it twice with another shape. parts: the same, as (axis or 0,
    estimates by plain name). rivals: effects that this data cannot tell from it, on the axes
    `open`. share: of the repeatable residual on its axes, explained together with the others.
    origin: where a user's own is from, as a machine file calls it.
    """

    id: str
    title: str
    axes: tuple[int, ...]
    parameters: Mapping[str, Estimate]
    parts: tuple[tuple[int, Mapping[str, Estimate]], ...] = ()
    rivals: tuple[str, ...] = ()
    experiment: str | None = None
    share: float = math.nan
    open: tuple[int, ...] = ()
    origin: str = ""

    def data(self) -> dict[str, Any]:
        """As in `--json`."""
        return {
            "id": self.id,
            "axes": list(self.axes),
            "parameters": {name: e.data() for name, e in self.parameters.items()},
            "rivals": list(self.rivals),
            "rivals_on": list(self.open),
            "experiment": self.experiment,
            "share": finite(self.share),
        }


@dataclass(frozen=True)
class Changed:
    """A parameter of the model that is another than the machine file says; runs: those that show
    it, where it is not all of them."""

    parameter: str
    nominal: float
    estimate: Estimate
    runs: tuple[str, ...] = ()

    def data(self) -> dict[str, Any]:
        """As in `--json`."""
        e = self.estimate
        ci = [finite(v) for v in e.ci95]
        return {
            "parameter": self.parameter,
            "from": self.nominal,
            "to": e.value,
            "ci95": ci,
            "unit": e.unit,
            "runs": list(self.runs),
        }


@dataclass(frozen=True)
class Tolerated(Changed):
    """A parameter that differs from the machine file but is no finding, its tolerance (one standard
    deviation), and the share of an axis' torque (from 1) that the difference makes."""

    tolerance: float = math.inf
    axis: int = 1
    share: float = 0.0

    @property
    def off(self) -> float:
        """By how many tolerances it differs."""
        return abs(self.estimate.value - self.nominal) / self.tolerance

    def data(self) -> dict[str, Any]:
        """As in `--json`."""
        more = {"tolerance": self.tolerance, "axis": self.axis, "share": self.share}
        return {k: v for k, v in super().data().items() if k != "runs"} | more


@dataclass(frozen=True)
class Residual:
    """Measured torque minus that of the model, RMS of each axis in its unit.

    nominal: with the machine file's own parameters; before: with the model's parameters fitted;
    after: with what was found. non_repeatable: what differs between passes; repeatable, of
    `before`, and repeatable_after: what they have in common. torque: RMS of the torque itself about
    its mean. held_out: the same on held-out runs, non-repeatable only if they repeat. All of the
    rows in which an axis moves; resting: share of the others in what is judged.
    """

    units: tuple[str, ...]
    torque: Array
    nominal: Array
    before: Array
    after: Array
    non_repeatable: Array
    repeatable: Array
    repeatable_after: Array
    held_out: Mapping[str, Array] = field(default_factory=dict)
    resting: Array = field(default_factory=lambda: np.zeros(0))

    @property
    def unit(self) -> str:
        """The unit of all axes; "" where they differ, so that no total makes sense."""
        return self.units[0] if len(set(self.units)) == 1 else ""

    def data(self) -> dict[str, Any]:
        """As in `--json`: totals over the axes, of held-out runs where there are any; null where
        axes differ in unit."""
        shown = {
            "before": self.before,
            "after": self.after,
            "non_repeatable": self.non_repeatable,
            "torque": self.torque,
            **self.held_out,
        }
        rows = {**shown, "nominal": self.held_out.get("nominal", self.nominal)}
        per_axis = {
            str(i + 1): {name: finite(float(v[i])) for name, v in rows.items()} | {"unit": unit}
            for i, unit in enumerate(self.units)
        }
        for i, share in enumerate(self.resting):
            per_axis[str(i + 1)]["resting"] = float(share)
        totals = {name: rms(v) if self.unit else math.nan for name, v in rows.items()}
        return {
            "unit": self.unit or None,
            **{name: finite(value) for name, value in totals.items()},
            "per_axis": per_axis,
            "judged_on": "held-out runs" if self.held_out else "the same runs",
        }


@dataclass(frozen=True)
class Diagnosis:
    """The whole answer; `notes` are sentences for the reader, `findings` what the logs had.

    confidence: how often such an answer was right where the truth is known; None where these runs
    are not like those of the study. doubt: why the model may not be this machine's. tracking:
    closed loop [urad] before and after, filled by the step that rebuilds it. parameters: of a base
    model that has no machine file, with what was found.
    """

    verdict: str
    effects: tuple[Named, ...]
    changed: tuple[Changed, ...]
    residual: Residual
    candidates: tuple[Candidate, ...] = ()
    maps: tuple[Map, ...] = ()
    notes: tuple[str, ...] = ()
    findings: tuple[str, ...] = ()
    runs: tuple[str, ...] = ()
    held_out: tuple[str, ...] = ()
    machine: str | None = None
    shown: Mapping[str, Any] = field(default_factory=dict)
    strips: tuple[Strip, ...] = ()
    remains: tuple[Rest, ...] = ()
    confidence: Confidence | None = None
    doubt: str = ""
    tolerated: tuple[Tolerated, ...] = ()
    parameters: tuple[Parameter, ...] = ()

    def data(self) -> dict[str, Any]:
        """As in `--json`."""
        return {
            "verdict": self.verdict,
            "confidence": self.confidence.share if self.confidence else None,
            "doubt": self.doubt,
            "compared": self.confidence.data() if self.confidence else None,
            "effects": [effect.data() for effect in self.effects],
            "changed": [change.data() for change in self.changed],
            "tolerated": [one.data() for one in self.tolerated],
            "parameters": [one.data() for one in self.parameters],
            "remains": [rest.data() for rest in self.remains],
            "residual": self.residual.data(),
            "machine": self.machine,
            "notes": list(self.notes),
            "findings": list(self.findings),
            "runs": list(self.runs),
            "held_out": list(self.held_out),
            "shown": dict(self.shown),
        }


def rms(values: Array) -> float:
    """Root of the mean square; NaN entries do not count."""
    known = values[np.isfinite(values)]
    return float(np.sqrt((known**2).mean())) if known.size else math.nan

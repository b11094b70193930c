"""From files to parameters: estimates, what the runs determine of them, how well they fit."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.base import Base
from flexhex.diagnosis.blocks import torque_at
from flexhex.diagnosis.calibrate import Calibrated
from flexhex.diagnosis.changed import NORMAL
from flexhex.diagnosis.estimation.estimate import Estimated, announced, estimate, never_negative
from flexhex.diagnosis.estimation.friction import GROUP as FRICTION
from flexhex.diagnosis.estimation.structure import Combination, structure
from flexhex.diagnosis.gram import safe_inverse
from flexhex.diagnosis.kinds import units_of
from flexhex.diagnosis.linearize import LOOSE
from flexhex.diagnosis.pairing import mispaired
from flexhex.diagnosis.prepare import Options, asked_of, misfit
from flexhex.diagnosis.verdict import Estimate
from flexhex.fmus.common.errors import LogError

Array = NDArray[np.float64]
NARROWER, WIDER = 0.5, 10.0
"""A parameter is determined by the runs if its standard deviation is this much smaller than what
was known of it, and would be with tolerances so much wider: else the file's other values do it;"""
SMALL = 0.05
"""or, where nothing was known, if its standard deviation makes less than this share of an axis'
torque."""
UNSEEN = 1e-4
"""Share of a combination that lies where neither runs nor file say anything: it has no value."""
SURE = 3.0
"""Standard deviations from which the runs contradict every machine."""
POOR = 0.2
"""Share of an axis' torque that is left, from which something large is missing."""
Progress = Callable[[str, int, int], None]


@dataclass(frozen=True)
class Parameter:
    """A parameter, or a sum of several.

    terms: names with coefficients; file: its value there, and tolerance: one standard deviation of
    that, infinite where nothing is known. determined: whether the runs say more of it than the
    file.
    """

    terms: tuple[tuple[str, float], ...]
    estimate: Estimate
    file: float
    tolerance: float
    determined: bool

    @property
    def name(self) -> str:
        """As it is read: `link_3.mc_x + 0.31 link_4.m`."""
        return summed(self.terms)

    @property
    def shift(self) -> float:
        """Difference from the file in tolerances; NaN where there is none."""
        known = 0 < self.tolerance < math.inf
        return (self.estimate.value - self.file) / self.tolerance if known else math.nan

    def data(self) -> dict[str, Any]:
        """As in `--json`."""
        return {
            "name": self.name,
            "terms": [{"parameter": name, "factor": factor} for name, factor in self.terms],
            **self.estimate.data(),
            "file": self.file if math.isfinite(self.tolerance) else None,
            "tolerance": self.tolerance if math.isfinite(self.tolerance) else None,
            "difference_in_tolerances": None if math.isnan(self.shift) else self.shift,
            "determined": self.determined,
        }


@dataclass(frozen=True)
class Errors:
    """RMS of what is left of the smoothed torque relative to its RMS (n,): with the file's
    parameters and no friction, and with the estimates. torque (n,): RMS in the axes' units."""

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
    sentences for the reader; findings: what the logs had. estimated: the fit.
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
    locked: tuple[str, ...]
    estimated: Estimated = field(repr=False)

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
            "notes": list(self.notes),
            "findings": list(self.findings),
            "runs": list(self.runs),
            "held_out": list(self.locked),
        }


def identify(
    paths: Sequence[Path],
    held_out: Sequence[Path] = (),
    machine_file: Path | None = None,
    options: Options | None = None,
    settle: float | None = None,
    progress: Progress = lambda *_: None,
) -> Identified:
    """Parameters of a base model from runs; held_out: runs that they are tried on.

    settle [s]: what is left out at the start of each run, instead of the base model's own. Errors
    of geometry are fitted only where `options.tolerance` names a tolerance of them. Raises
    LogError, MachineError or UsageError for what cannot be read or does not fit.
    """
    asked_for = options or Options()
    progress("reading", 0, 3)
    base, asked, trouble = asked_of(paths, held_out, machine_file, asked_for)
    base = _plain(base, asked_for.tolerance, settle)
    if trouble := trouble or mispaired(base, asked.runs):
        raise LogError(trouble)
    progress("fitting the parameters", 1, 3)
    found, smoothed = estimate(base, asked.runs)
    if trouble := misfit(found.made):
        raise LogError(trouble)
    progress("on held-out runs", 2, 3)
    errors = _errors(found, found.made)
    other = _errors(found, found.along(asked.judged)) if asked.judged else None
    seen = _Seen(found)
    which = structure(found.made.base, found.made.blocks)
    names = [known.name for known in found.known]
    late = next(i for i, k in enumerate(found.known) if k.group == "delay")
    shown = [i for i, k in enumerate(found.known) if k.group != "delay"]
    progress("done", 3, 3)
    return Identified(
        asked_for.base,
        tuple(seen.parameter(Combination(((place, 1.0),))) for place in shown),
        tuple(seen.parameter(c) for c in which.combinations),
        tuple(names[place] for place in which.silent),
        units_of(base, base.n, "N m"),
        errors,
        other,
        seen.parameter(Combination(((late, 1.0),))).estimate,
        tuple(_notes(found, errors)),
        (*asked.findings, *filter(None, [smoothed])),
        *asked.names,
        found,
    )


def summed(terms: Sequence[tuple[str, float]], most: int | None = None) -> str:
    """`link_3.mc_x + 0.31 link_4.m`; no more than so many terms, of which the last says how many
    there are."""
    listed = list(terms if most is None or len(terms) <= most else terms[: most - 1])
    text = ""
    for k, (name, factor) in enumerate(listed):
        sign = " - " if factor < 0 else " + "
        size = f"{abs(factor):.3g}"
        shown = name if size == "1" else f"{size} {name}"
        text += (sign if k else "-" * (factor < 0)) + shown
    left = len(terms) - len(listed)
    return text + (f" + {left} more" if left else "")


def _plain(base: Base, tolerance: Mapping[str, float], settle: float | None) -> Base:
    """The base model with the geometry of its file, unless its tolerance was given."""
    found = copy(base)
    if "geometry" not in tolerance:
        found.geometry = None
    if settle is not None:
        found.settle = settle
    return found


class _Seen:
    """What the runs say of parameters and their sums."""

    def __init__(self, found: Estimated) -> None:
        self.found, made, reg = found, found.made, found.regression
        self.more = announced(made)
        G = np.diag(reg.prior) + np.sum([part for part, _ in reg.grams], axis=0)
        self.unseen = np.eye(len(G)) - reg.covariance @ G
        loose = reg.prior / WIDER**2
        self.alone = found.level * safe_inverse(G - np.diag(reg.prior - loose), loose)
        rms = np.array([np.sqrt((np.concatenate(made.B)[:, i] ** 2).mean(axis=0))
                        for i in range(made.base.n)])  # fmt: skip
        torque = np.maximum(made.torque_rms, np.finfo(float).tiny)
        self.share = (rms / torque[:, None]).max(axis=0) / made.scale

    def parameter(self, combination: Combination) -> Parameter:
        """A sum of parameters by their places."""
        found, known = self.found, self.found.known
        places = [place for place, _ in combination.terms]
        c = np.zeros(len(known))
        c[places] = [factor for _, factor in combination.terms]
        value = float(c @ (found.values + self.more))
        file = float(c @ (np.array([k.nominal for k in known]) + self.more))
        # what is assumed of friction is no file's
        wide = [np.inf if known[p].group == FRICTION else known[p].tolerance for p in places]
        tolerance = float(np.linalg.norm(np.abs(c[places]) * np.array(wide)))
        q = c * found.made.scale
        lost = np.linalg.norm(self.unseen.T @ q) > UNSEEN * np.linalg.norm(q)
        deviation = math.inf if lost else math.sqrt(max(float(c @ found.covariance @ c), 0.0))
        alone = math.sqrt(max(float(q @ self.alone @ q), 0.0))
        if math.isfinite(tolerance):
            determined = max(deviation, alone) < NARROWER * LOOSE * tolerance
        else:
            size = float((self.share[places] / np.abs(c[places])).min())
            determined = max(deviation, alone) * size < SMALL
        low, high = value - NORMAL * deviation, value + NORMAL * deviation
        if len(places) == 1 and (never_negative(known[places[0]]) or known[places[0]].positive):
            low = max(low, 0.0)
        terms = tuple((known[p].name, float(c[p])) for p in places)
        estimate = Estimate(value, (low, high), known[places[0]].unit)
        return Parameter(terms, estimate, file, tolerance, bool(determined))


def _errors(found: Estimated, there: Calibrated) -> Errors:
    kept = [block.usable for block in there.blocks]

    def rms(parts: Sequence[Array]) -> Array:
        rows = np.concatenate([part[good] for part, good in zip(parts, kept, strict=True)])
        return np.asarray(np.sqrt((rows**2).mean(axis=0)))

    window, delay = there.base.window, there.fitted.delay
    torque = rms([torque_at(block, window, delay) for block in there.blocks])
    size = np.maximum(torque, np.finfo(float).tiny)
    file = rms(there.residual(there.nominal))
    return Errors(torque, file / size, rms(there.residual(found.q)) / size)


def _notes(found: Estimated, errors: Errors) -> list[str]:
    deviation = np.maximum(np.sqrt(np.diag(found.covariance)), np.finfo(float).tiny)
    off = np.abs(found.free - found.values) / deviation
    against = {name: float(max(off[k] for k in own)) for name, own in found.wrong.items()}
    sure = [name for name, size in against.items() if size > SURE]
    within = [name for name in against if name not in sure]
    notes = []
    if sure:
        notes.append(
            f"{', '.join(sure)}: the runs alone ask for values that no machine has, up to"
            f" {max(against[name] for name in sure):.1f} standard deviations away; these are the"
            " nearest that one can have. Something else is missing: `flexhex diagnose` says what"
        )
    if within:
        notes.append(
            f"{', '.join(within)}: the best fit lies at values that no machine has, within the"
            " noise; these are the nearest that one can have"
        )
    there = {known.name for known in found.known}
    same = [str(i + 1) for i in range(found.made.base.n) if f"o[{i + 1}]" not in there]
    if same:
        notes.append(
            f"an offset of axis {', '.join(same)} acts as parameters of the base model do, on these"
            " motions: it is not fitted beside them"
        )
    poor = [str(i + 1) for i, left in enumerate(errors.fitted) if left > POOR]
    if poor:
        notes.append(
            f"more than {POOR:.0%} of the torque of axis {', '.join(poor)} is left: the intervals"
            " hold for this model, which lacks something: `flexhex diagnose` says what"
        )
    return notes

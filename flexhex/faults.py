"""Faults that components reported during a run, for console, report and JSON alike."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from flexhex.run import Study
from ssp.results import Result


@dataclass(frozen=True)
class Fault:
    """One component's fault in one run.

    value: the first that is not 0; first [s]: since when; share: of the samples that have one.
    """

    run: str
    signal: str
    value: float
    first: float
    share: float

    def __str__(self) -> str:
        return (
            f"{self.run}: {self.signal} = {self.value:g} from {self.first:g} s on,"
            f" {self.share:.1%} of the samples"
        )


def faults(run: str, result: Result) -> list[Fault]:
    """The faults of one result, whose run has that title."""
    found = []
    for group in result.groups.values():
        for name, values in group.signals.items():
            if name.endswith(".fault") and values.any():
                first = int(values.nonzero()[0][0])
                time, share = float(group.time[first]), float((values != 0).mean())
                found.append(Fault(run, name, float(values[first]), time, share))
    return found


def study_faults(study: Study) -> Sequence[Fault]:
    """The faults of all rows of the report's tables."""
    found = []
    for outcome in (study.fit_outcome, *study.table, *study.extra):
        found += faults(outcome.case.title, outcome.result)
    for outcome in study.actuators:
        found += faults(f"actuators alone, {outcome.case.title}", outcome.result)
    return found

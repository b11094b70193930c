"""Faults that components reported during a run, for console, report and JSON alike."""

from __future__ import annotations

from dataclasses import dataclass

from flexhex.ssp.fmu import item_of
from flexhex.ssp.results import Result


@dataclass(frozen=True)
class Fault:
    """One component's fault in one run.

    value: the first that is not 0; first [s]: since when; share: of the samples that have one;
    item: what the FMU calls the value, empty for a result that does not say it.
    """

    run: str
    signal: str
    value: float
    first: float
    share: float
    item: str = ""

    def __str__(self) -> str:
        shown = f"{self.value:g} ({self.item})" if self.item else f"{self.value:g}"
        return (
            f"{self.run}: {self.signal} = {shown} from {self.first:g} s on,"
            f" {self.share:.1%} of the samples"
        )


def faults(run: str, result: Result) -> list[Fault]:
    """The faults of one result, whose run has that title."""
    listed = []
    for group in result.groups.values():
        for name, values in group.signals.items():
            if name.endswith(".fault") and values.any():
                first = int(values.nonzero()[0][0])
                time, share = float(group.time[first]), float((values != 0).mean())
                item = item_of(group.descriptions.get(name, ""), values[first])
                listed.append(Fault(run, name, float(values[first]), time, share, item))
    return listed

"""What one `flexhex run` computed: finished cases, the fit, experiments."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from flexhex.diagnosis.estimation.identify import Fit
from flexhex.simulation.builder import Builder
from flexhex.simulation.cases import Case
from flexhex.simulation.faults import Fault, faults
from flexhex.simulation.metrics import Figures
from flexhex.simulation.passes import repeatable_share
from flexhex.simulation.published import Published, published_row
from flexhex.ssp.results import Result


@dataclass(frozen=True)
class Outcome:
    """One finished case: figures evaluated after the settling time, samples, provenance."""

    case: Case
    figures: Figures
    result: Result
    provenance: Mapping[str, str | int | float]

    @property
    def real_time_factor(self) -> float:
        """Simulated seconds in a second of computing."""
        return self.result.duration / self.result.wall


@dataclass(frozen=True)
class Rows:
    """The rows of Table I of one machine, and what was published of it."""

    outcomes: tuple[Outcome, ...] = ()
    published: Published | None = None

    def __bool__(self) -> bool:
        return bool(self.outcomes)

    def of(self, name: str) -> Outcome:
        """The outcome of the case of that name."""
        return next(o for o in self.outcomes if o.case.name == name)


@dataclass(frozen=True)
class PaperRun:
    """All that one `flexhex run` computed. table, actuators: the cases of [SH, Table I] on the
    whole machine and on its actuators alone; extra: variants of them; wall: time it took [s]."""

    builder: Builder
    fit: Fit
    fit_outcome: Outcome
    table: Rows
    extra: tuple[Outcome, ...]
    actuators: Rows
    experiments: Mapping[str, Any]
    command: str
    wall: float

    @property
    def compared(self) -> tuple[Outcome, ...]:
        """The three cases of one pass: feedback only, fixed, adaptive."""
        return tuple(o for o in self.table.outcomes if o.case.name != "repeatability")

    @property
    def adaptive(self) -> Outcome:
        """The adaptive row."""
        return self.table.of("adaptive")

    @property
    def share(self) -> float:
        """Share of the adaptive run's feedback torque that repeats."""
        return repeatable_share(self.table.of("repeatability").figures, self.adaptive.figures)

    @property
    def is_model(self) -> bool:
        """Whether the simulated machine is its model, for want of a truth file."""
        return not self.builder.has_truth

    @property
    def faults(self) -> list[Fault]:
        """The faults of all rows of the report's tables."""
        whole = (self.fit_outcome, *self.table.outcomes, *self.extra)
        listed = [(outcome.case.title, outcome) for outcome in whole]
        listed += [(f"actuators alone, {o.case.title}", o) for o in self.actuators.outcomes]
        return [fault for title, o in listed for fault in faults(title, o.result)]

    @property
    def summary(self) -> str:
        """The result of the table in one sentence."""
        feedback, fixed, adaptive = (o.figures.e for o in self.compared)
        sentence = (
            f"RMS tracking error {feedback:.1f} µrad with feedback only, {fixed:.1f} µrad with"
            f" fixed and {adaptive:.1f} µrad with adaptive feedforward"
        )
        ratio = self.adaptive.figures.tau_fb / self.compared[0].figures.tau_fb
        share = f"{100 * ratio:.2f} %"
        return f"{sentence}, whose feedback torque is {share} of that with feedback only."


def figure_rows(rows: Rows | Sequence[Outcome]) -> list[dict[str, str | float | None]]:
    """Rows for `metrics.figure_columns`, each with the published one below it, if there is one."""
    known = rows.published.rows if isinstance(rows, Rows) and rows.published else {}
    listed: list[dict[str, str | float | None]] = []
    for outcome in rows.outcomes if isinstance(rows, Rows) else rows:
        listed.append({"title": outcome.case.title, **vars(outcome.figures)})
        if outcome.case.name in known:
            listed.append(published_row(known[outcome.case.name]))
    return listed

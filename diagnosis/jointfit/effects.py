"""Effects that were found: where, with which shape, and the columns of their torque."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from flexhex.diagnosis.regression.regression import Columns

if TYPE_CHECKING:
    from flexhex.diagnosis.hypotheses.candidates import Bench


@dataclass(frozen=True)
class Part:
    """An effect on one axis (from 0; None: on the whole) with its shape and whitened columns.

    still: places of gains that are zero, as they may not be negative; their columns are zero.
    rivals: effects that these runs cannot tell from it on this axis.
    """

    id: str
    axis: int | None
    shape: dict[str, float]
    columns: Columns
    still: tuple[int, ...] = ()
    rivals: tuple[str, ...] = ()

    @staticmethod
    def of(
        bench: Bench,
        id: str,
        axis: int | None,
        shape: dict[str, float],
        still: tuple[int, ...] = (),
        rivals: tuple[str, ...] = (),
    ) -> Part:
        """With its columns along the runs of a bench."""
        columns = bench.columns(id, axis or 0, shape)
        values = columns.values.copy() if still else columns.values
        values[:, list(still)] = 0.0
        return Part(id, axis, shape, Columns(columns.axis, values), still, rivals)

    def moved(self, bench: Bench, shape: dict[str, float]) -> Part:
        """With another shape, or along other runs."""
        return Part.of(bench, self.id, self.axis, shape, self.still, self.rivals)


@dataclass(frozen=True)
class SelectedEffect:
    """An effect on all its axes."""

    id: str
    parts: tuple[Part, ...]

    @property
    def axes(self) -> tuple[int, ...]:
        """Axes from 0; nothing where it acts on the whole."""
        return tuple(part.axis for part in self.parts if part.axis is not None)

"""Values with their intervals, and parameters of a base model, as they are said."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Estimate:
    """A value with its 95 % interval, in `unit`; told: it says something to a reader."""

    value: float
    ci95: tuple[float, float]
    unit: str
    told: bool = True

    @property
    def determined(self) -> bool:
        """Whether its interval has ends."""
        return not any(math.isinf(end) for end in self.ci95)

    def data(self) -> dict[str, Any]:
        """As in `--json`."""
        return {"value": self.value, "ci95": [finite(v) for v in self.ci95], "unit": self.unit}


@dataclass(frozen=True)
class Parameter:
    """A parameter, or a sum of several.

    terms: names with coefficients; file: its value there, and tolerance: one standard deviation of
    that, infinite where nothing is known. determined: whether the runs say more of it than the
    file; exact: whether the file allows no other value.
    """

    terms: tuple[tuple[str, float], ...]
    estimate: Estimate
    file: float
    tolerance: float
    determined: bool
    exact: bool = False

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


def summed(terms: Sequence[tuple[str, float]], first: int | None = None) -> str:
    """`link_3.mc_x + 0.31 link_4.m`; of only the first so many: `link_3.mc_x + 1 more`."""
    listed, text = terms[:first], ""
    for k, (name, factor) in enumerate(listed):
        sign = " - " if factor < 0 else " + "
        size = f"{abs(factor):.3g}"
        shown = name if size == "1" else f"{size} {name}"
        text += (sign if k else "-" * (factor < 0)) + shown
    left = len(terms) - len(listed)
    return text + (f" + {left} more" if left else "")


def finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None

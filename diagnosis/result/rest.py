"""What repeats beside all that is named."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

UNCONFIRMED = "but one trajectory cannot show it: record another one"
REFUTED = "but not on the held-out runs"
TOO_LARGE = "but too much would be left for a name"
UNSURE = "but these runs do not determine how large"
"""Why effects that explain a part of what repeats have no name."""


@dataclass(frozen=True)
class Rest:
    """What repeats on an axis (from 1) beside all that is named: its RMS in `unit`, and as a share
    of the axis' torque; what it goes with, where that is known. beside: effects that are named
    leave it there; form: no more than errors of their form leave. fitted: effects that explain a
    part of it, and have no name; fitted_share: of its squares, which they explain; why: they have
    none. repeats: seen between passes; else it is only what is left."""

    axis: int
    rms: float
    unit: str
    share: float
    what: str = ""
    beside: bool = False
    form: bool = False
    fitted: tuple[str, ...] = ()
    fitted_share: float = 0.0
    why: str = ""
    repeats: bool = True

    def data(self) -> dict[str, Any]:
        """As in `--json`."""
        return asdict(self)

    def sentence(self) -> str:
        """For the notes."""
        there = "repeats" if self.repeats else "is left"
        text = f"{self.rms:.2g} {self.unit} on axis {self.axis} {there}"
        text += " beside what was found" if self.beside else ""
        goes = f": it goes with {self.what}" if self.what else ""
        if self.form:
            return f"{text}{goes}; the form of what is named there is not exact, or more is missing"
        if self.fitted:
            part = f"would explain {100 * self.fitted_share:.0f} % of its mean square"
            return f"{text}{goes}; {', '.join(self.fitted)} {part}, {self.why}"
        if not self.repeats:
            return f"{text}, and nothing that is named explains it{goes}"
        return f"{text} and is explained by no effect of the library{goes}"

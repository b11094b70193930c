"""The tables of docs/gateway-faults.md: fault, rule, reaction. Tests make their rows."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from tests.conftest import ROOT

FILE = ROOT / "docs" / "gateway-faults.md"
FIGURES = ROOT / "docs" / "gateway-figures.md"


@dataclass(frozen=True)
class Place:
    """Where a table stands in the file, and its head."""

    begin: str
    end: str
    head: tuple[str, str]
    file: Path = FILE

    def written(self) -> list[str]:
        """Rows that stand there."""
        inside = self.file.read_text(encoding="utf-8").split(self.begin)[1].split(self.end)[0]
        return [line for line in inside.splitlines() if line.startswith("| ")][1:]


FAULTS = Place(
    "<!-- faults: written by tests/gateway -->",
    "<!-- end of faults -->",
    (
        "| fault | rule | reaction | cycles to the trip | ms to zero torque |",
        "|---|---|---|---|---|",
    ),
)
FALLS = Place(
    "<!-- falls: written by tests/gateway -->",
    "<!-- end of falls -->",
    (
        "| fault | rule | stop | cycles to the trip | fastest axis [rad/s] | largest angle [rad] "
        "| drives at the end | not confirmed |",
        "|---|---|---|---|---|---|---|---|",
    ),
)
MARGINS = Place(
    "<!-- margins: written by tests/gateway -->",
    "<!-- end of margins -->",
    ("| rule | limit | adaptive | fixed | feedback only |", "|---|---|---|---|---|"),
    FIGURES,
)

DRIFTS = Place(
    "<!-- drifts: written by tests/gateway -->",
    "<!-- end of drifts -->",
    (
        "| encoder off by [rad] | largest change of any torque: least seen drift [N m] "
        "| best seen drift [N m] |",
        "|---|---|---|",
    ),
    FIGURES,
)


@dataclass(frozen=True)
class Row:
    """One line. cycles: from the fault to the trip; ms: to the first frame without torque."""

    fault: str
    rule: str
    reaction: str
    cycles: int | None
    ms: float | None

    def __str__(self) -> str:
        cells = (self.cycles, self.ms)
        shown = ["–" if cell is None else f"{cell:g}" for cell in cells]
        return "| " + " | ".join([self.fault, self.rule, self.reaction, *shown]) + " |"


@dataclass(frozen=True)
class Fall:
    """One line. cycles: from the fault to the trip; speed, angle: largest of any axis after it."""

    fault: str
    rule: str
    stop: str
    cycles: int | None
    speed: float
    angle: float
    drives: str
    unknown: tuple[int, ...]

    def __str__(self) -> str:
        axes = ", ".join(map(str, self.unknown)) or "–"
        cycles = "–" if self.cycles is None else str(self.cycles)
        motion = f"{self.speed:.2f}", f"{self.angle:.2f}"
        cells = (self.fault, self.rule, self.stop, cycles, *motion, self.drives, axes)
        return "| " + " | ".join(cells) + " |"


@dataclass(frozen=True)
class Margin:
    """One line. shares: of the limit, the largest of every run of a kind [%]; None: not judged."""

    fault: str
    limit: str
    shares: tuple[int | None, ...]

    def __str__(self) -> str:
        shown = ("–" if share is None else f"{share} %" for share in self.shares)
        return "| " + " | ".join([f"`{self.fault}`", self.limit, *shown]) + " |"


@dataclass(frozen=True)
class Off:
    """One line. off: of an encoder [rad]; least, most: largest change of any torque by it [N m]."""

    off: float
    least: float
    most: float

    @property
    def fault(self) -> str:
        """What the line is of."""
        return f"{self.off:g}"

    def __str__(self) -> str:
        return f"| {self.fault} | {self.least:.2f} | {self.most:.2f} |"


def alike(one: str, other: str) -> bool:
    """Whether two rows say the same, as far as processors agree: words to the letter.

    Each rounds sin and cos in its own way (glibc takes fused operations where there are some), so
    the last bits differ. A mean that grows slowly meets its limit a cycle sooner or later.
    """
    cells = one.split(" | "), other.split(" | ")
    if len(cells[0]) != len(cells[1]):
        return False
    return all(a == b or _near(k, a, b) for k, (a, b) in enumerate(zip(*cells, strict=True)))


def _near(column: int, one: str, other: str) -> bool:
    """Cycles to a thousandth; speed, angle and time to two hundredths."""
    if column not in (3, 4, 5):
        return False
    try:
        a, b = float(one), float(other)
    except ValueError:
        return False
    return round(abs(a - b), 6) <= (1e-3 * a if column == 3 else 0.02)


@dataclass
class Table:
    """Rows of this session; `update` writes them, otherwise each must stand in the file."""

    update: bool
    place: Place = FAULTS
    rows: dict[str, Row | Fall | Margin | Off] = field(default_factory=dict)

    def add(self, row: Row | Fall | Margin | Off) -> None:
        """Keep a row, and compare it with the file."""
        listed = any(alike(line, str(row)) for line in self.place.written())
        if self.update and not listed:
            self.rows[row.fault] = row
        file = self.place.file
        assert listed or self.update, f"{file} does not say: {row}; pytest --update writes it"

    def write(self) -> None:
        """Put the rows of this session into the file, in the place of those with their names."""
        if not (self.update and self.rows):
            return
        place = self.place
        text = place.file.read_text(encoding="utf-8")
        before, rest = text.split(place.begin)
        _, after = rest.split(place.end)
        rows = {line.split(" | ")[0][2:]: line for line in place.written()}
        rows |= {str(row).split(" | ")[0][2:]: str(row) for row in self.rows.values()}
        lines = [before + place.begin, *place.head, *rows.values(), place.end + after]
        place.file.write_text("\n".join(lines), encoding="utf-8")

"""The table of docs/gateway.md: fault, rule, reaction, time. Tests make its rows."""

from __future__ import annotations

from dataclasses import dataclass, field

from tests.conftest import ROOT

FILE = ROOT / "docs" / "gateway.md"
BEGIN, END = "<!-- faults: written by tests/gateway -->", "<!-- end of faults -->"
HEAD = (
    "| fault | rule | reaction | cycles to the trip | ms to zero torque |",
    "|---|---|---|---|---|",
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


@dataclass
class Table:
    """Rows of this session; `update` writes them, otherwise each must stand in the file."""

    update: bool
    rows: dict[str, Row] = field(default_factory=dict)

    def add(self, row: Row) -> None:
        """Keep a row, and compare it with the file."""
        self.rows[row.fault] = row
        if not self.update:
            assert str(row) in written(), f"{FILE} does not say: {row}; pytest --update writes it"

    def write(self) -> None:
        """Put the rows of this session into the file, in the place of those with their names."""
        if not (self.update and self.rows):
            return
        text = FILE.read_text(encoding="utf-8")
        before, rest = text.split(BEGIN)
        _, after = rest.split(END)
        rows = {line.split(" | ")[0][2:]: line for line in written()}
        rows |= {name: str(row) for name, row in self.rows.items()}
        lines = rows.values()
        FILE.write_text("\n".join([before + BEGIN, *HEAD, *lines, END + after]), encoding="utf-8")


def written() -> list[str]:
    """Rows that stand in the file."""
    inside = FILE.read_text(encoding="utf-8").split(BEGIN)[1].split(END)[0]
    return [line for line in inside.splitlines() if line.startswith("| ")][1:]

"""Tables of the terminal: each column has a heading, a unit and a number format.

Every table that a command prints is made here.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.console import Console, Group
from rich.markup import escape
from rich.table import Table

NONE = "–"
"""What stands in the place of a value that does not exist."""
WIDE = 10_000
"""Width that no table reaches: a terminal wraps long lines itself, a pipe keeps them whole."""
GROUP = "group"
"""Key of a row that is the heading of those below it."""
Value = str | float | None
Row = Mapping[str, Value]


@dataclass(frozen=True)
class Column:
    """key: of the value in a row. number: its format (".1f"); text without one, to the left.

    right: text to the right, too. fold: in a narrow terminal text goes on in a further line.
    """

    key: str
    heading: str
    unit: str = ""
    number: str = ""
    right: bool = False
    fold: bool = False

    def text(self, row: Row) -> str:
        """The value of a row in print. TypeError for what is neither text nor a number."""
        value = row[self.key]
        if value is None or value != value:
            return NONE
        if not isinstance(value, str | int | float):
            raise TypeError(f"column {self.key!r}: {value!r} is neither text nor a number")
        return (
            format(value, self.number) if self.number and not isinstance(value, str) else str(value)
        )

    @property
    def title(self) -> str:
        """Heading and unit in one line: `e [µrad]`."""
        return f"{self.heading} [{self.unit}]" if self.unit else self.heading


def printed(unit: str) -> str:
    """A unit as it is printed: `kg m²` of `kg m2`; 1 reads as a number and is left out."""
    return (
        ""
        if unit == "1"
        else re.sub(r"\b(m|s|mm|rad)([23])\b", lambda u: u[1] + "²³"[int(u[2]) - 2], unit)
    )


def table(title: str, columns: Sequence[Column], rows: Sequence[Row], total: bool = False) -> Group:
    """Rows under their title, units below the headings. `class` of a row is its colour (`dim`).

    total: a line before the last one of several rows.
    """
    drawn = Table(box=SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    with_units = any(column.unit for column in columns)
    for column in columns:
        unit = f"\n[dim]{escape(column.unit)}[/]" if with_units else ""
        drawn.add_column(
            escape(column.heading) + unit,
            justify="right" if column.number or column.right else "left",
            overflow="fold",
            no_wrap=not column.fold,
        )
    for k, row in enumerate(rows):
        if GROUP in row:
            drawn.add_section()
            drawn.add_row(f"[bold]{escape(str(row[GROUP]))}[/]")
            continue
        last = total and k == len(rows) - 2
        cells = (escape(c.text(row)) for c in columns)
        drawn.add_row(*cells, style=str(row.get("class", "")), end_section=last)
    return Group(f"[bold]{escape(title)}[/]", drawn)


def texts(columns: Sequence[Column], rows: Sequence[Row]) -> tuple[list[str], list[list[str]]]:
    """Headings with units, and the cells of all rows, in print."""
    return [c.title for c in columns], [[c.text(row) for c in columns] for row in rows]


def console() -> Console:
    """stdout for tables and sentences, which are never cut off, in a terminal or a pipe."""
    return Console(width=WIDE, highlight=False)


def html(columns: Sequence[Column], rows: Sequence[Row]) -> Any:
    """The same table as safe HTML (markupsafe.Markup); `class` of a row is its HTML class."""
    from markupsafe import Markup

    cell, line = Markup("<td>{}</td>"), Markup("<tr class='{}'>{}</tr>\n")
    head, empty = Markup("<th>{}<small>{}</small></th>"), Markup("")
    heads = empty.join(
        head.format(_subscript(c.heading), c.unit.replace(" ", "\N{NO-BREAK SPACE}"))
        for c in columns
    )
    body = empty.join(
        line.format(row.get("class", ""), empty.join(cell.format(c.text(row)) for c in columns))
        for row in rows
    )
    return Markup("<table>\n<thead><tr>{}</tr></thead>\n{}</table>").format(heads, body)


def _subscript(heading: str) -> Any:
    """`τ_FB` with its index below the line."""
    from markupsafe import Markup

    symbol, _, index = heading.partition("_")
    return Markup("{}<sub>{}</sub>").format(symbol, index) if index else heading

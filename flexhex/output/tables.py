"""Tables of the terminal."""

from __future__ import annotations

from rich.box import SIMPLE_HEAD
from rich.markup import escape
from rich.table import Table


def table(title: str, listed: list[dict[str, str]]) -> Table:
    """Rows under their title."""
    made = Table(title=title, title_justify="left", title_style="bold", box=SIMPLE_HEAD)
    for k, key in enumerate(listed[0]):
        made.add_column(escape(key), justify="right" if k else "left")
    for row in listed:
        made.add_row(*row.values())
    return made

"""What is said of a result, part by part: in the terminal, as text, and as HTML for a notebook."""

from __future__ import annotations

import io
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from rich.console import Console

from flexhex.output.tables import WIDE, Column, Row, table, texts

SENTENCE = "max-width: 50em; margin: 0.5em 0"
"""Style of a paragraph in HTML: no longer than can be read."""

PADDED = "padding: 0.15em 0.6em"
"""Style of a cell."""
LONG = 30
"""Rows of a table from which on a notebook shows its title alone, to be opened."""


@dataclass(frozen=True)
class Sentence:
    """Text alone, in a style of rich."""

    text: str
    style: str | None = None


@dataclass(frozen=True)
class Titled:
    """A table under its title; total: a line before the last of several rows."""

    title: str
    columns: Sequence[Column]
    rows: Sequence[Row]
    total: bool = False


Part = Sentence | Titled


class Shown:
    """A result that shows itself: as text in Python, as HTML in a notebook."""

    def parts(self) -> Iterable[Part]:
        """What is shown. NotImplementedError here."""
        raise NotImplementedError

    def __repr__(self) -> str:
        """What the command prints."""
        file = io.StringIO()
        print_parts(Console(file=file, width=WIDE, highlight=False), self.parts())
        return "\n".join(line.rstrip() for line in file.getvalue().strip("\n").splitlines())

    def _repr_html_(self) -> str:
        """The same for Jupyter."""
        return html(self.parts())


def say(out: Console, text: str, style: str | None = None) -> None:
    """A line that is text alone, however long."""
    out.print(text, style=style, markup=False, highlight=False, soft_wrap=style is None)


def print_parts(out: Console, parts: Iterable[Part]) -> None:
    """All of it on a console."""
    for part in parts:
        if isinstance(part, Sentence):
            say(out, part.text, part.style)
        else:
            out.print(table(part.title, part.columns, part.rows, part.total))


def html(parts: Iterable[Part]) -> str:
    """All of it as HTML without a style sheet; every text is escaped, long tables are folded."""
    from markupsafe import Markup

    sentence = Markup("<p style='{}'>{}</p>\n")
    pieces = [
        sentence.format(SENTENCE, part.text.strip()) if isinstance(part, Sentence) else _table(part)
        for part in parts
    ]
    return str(Markup("").join(pieces))


def _table(part: Titled) -> Any:
    from markupsafe import Markup

    headings, rows = texts(part.columns, part.rows)
    sides = ["right" if c.number or c.right else "left" for c in part.columns]
    cell, head = (
        Markup(f"<{tag} style='text-align: {{}}; {PADDED}'>{{}}</{tag}>") for tag in ("td", "th")
    )
    line, empty = Markup("<tr>{}</tr>\n"), Markup("")
    lines = [
        line.format(empty.join(map(kind.format, sides, texts_)))
        for kind, texts_ in ((head, headings), *((cell, row) for row in rows))
    ]
    rest = "<table>\n<thead>{}</thead>\n{}</table>\n"
    whole = f"<p style='margin: 1em 0 0'><b>{{}}</b></p>\n{rest}"
    if len(rows) > LONG:
        whole = f"<details><summary><b>{{}}</b></summary>\n{rest}</details>\n"
    return Markup(whole).format(part.title, lines[0], empty.join(lines[1:]))

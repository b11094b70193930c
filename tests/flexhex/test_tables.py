"""Tables of the terminal: units, no Python objects, nothing cut off."""

from __future__ import annotations

import io
import re

import pytest
from rich.console import Console

from flexhex.output.tables import GROUP, WIDE, Column, html, table, texts
from tests.conftest import ROOT

COLUMNS = (Column("name", "case"), Column("e", "e_FB", "µrad", ".1f"), Column("n", "n", "", "d"))
ROWS = [
    {"name": "fixed [1]", "e": 28.249, "n": 3},
    {"name": "none", "e": float("nan"), "n": None, "class": "dim"},
]


def printed(width: int = WIDE) -> list[str]:
    stream = io.StringIO()
    Console(file=stream, width=width).print(table("A title " * 30, COLUMNS, ROWS))
    return [" ".join(line.split()) for line in stream.getvalue().splitlines() if line.strip()]


def test_title_stands_on_one_line_units_below_headings() -> None:
    """Longer than the table and than 80 characters."""
    title, heads, units, rule, *rows = printed()
    assert title == ("A title " * 30).strip()
    assert (heads, units) == ("case e_FB n", "µrad")
    assert set(rule) == {"─"}
    assert rows == ["fixed [1] 28.2 3", "none – –"]


def test_value_that_is_no_text_and_no_number_is_refused() -> None:
    """A tuple once stood in a column of the terminal."""
    with pytest.raises(TypeError, match=r"column 'e': \(1, 2\) is neither"):
        COLUMNS[1].text({"e": (1, 2)})  # type: ignore[dict-item]


def test_html_is_escaped_and_marks_its_rows() -> None:
    text = str(html((Column("a", "τ_FB", "N m"),), [{"a": "<b>", "class": "dim"}]))
    assert "<th>τ<sub>FB</sub><small>N\N{NO-BREAK SPACE}m</small></th>" in text
    assert "<tr class='dim'><td>&lt;b&gt;</td></tr>" in text


def test_texts_carry_the_unit_in_the_heading() -> None:
    assert texts(COLUMNS[:2], ROWS) == (
        ["case", "e_FB [µrad]"],
        [["fixed [1]", "28.2"], ["none", "–"]],
    )


def test_rows_may_stand_in_groups_and_end_with_a_total() -> None:
    columns = (Column("name", "axis", right=True), Column("e", "e", "", ".1f"))
    rows = [{GROUP: "upper [arms]"}, *({"name": n, "e": 1.0} for n in ("1", "2", "all"))]
    stream = io.StringIO()
    Console(file=stream, width=WIDE).print(table("", columns, rows, total=True))
    lines = [line.split() for line in stream.getvalue().splitlines()]
    group, total = lines.index(["upper", "[arms]"]), lines.index(["all", "1.0"])
    assert lines[group + 1 : group + 3] == [["1", "1.0"], ["2", "1.0"]]
    assert total == group + 4, "a line before it"


def test_column_that_folds_loses_nothing_in_a_narrow_terminal() -> None:
    columns = (Column("name", "effect", fold=True), Column("e", "e", "", ".1f"))
    stream = io.StringIO()
    Console(file=stream, width=20).print(table("", columns, [{"name": "word " * 8, "e": 1.0}]))
    assert stream.getvalue().split().count("word") == 8


def test_no_other_module_draws_tables_of_the_terminal() -> None:
    """One formatter for all commands; a bar of progress is no table."""
    users = [
        path.name
        for path in (ROOT / "flexhex").rglob("*.py")
        if re.search(r"from rich(\.table)? import .*\bTable\b", path.read_text(encoding="utf-8"))
    ]
    assert sorted(users) == ["bars.py", "tables.py"]

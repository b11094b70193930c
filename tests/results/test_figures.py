"""Figures of README.md and docs/ are those of the results files, and no others stand there."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest

from results import record, render
from results.figures import FIGURES, TABLES
from results.record import FOLDER, ROOT
from tests.results.specifications import SPECIFICATIONS

TEXTS = render.texts()
WRITTEN = ("docs/machine-file.md",)
"""Pages that hold the machine file's values, written by a program and compared with it."""
READMES = sorted((ROOT / "flexhex").glob("**/README.md"))
TYPED = [path for path in TEXTS if path.relative_to(ROOT).as_posix() not in WRITTEN] + READMES
FILES = sorted(FOLDER.glob("*.json"))
UNITS = "µrad|mrad|rad|mN m|N m|nm|µm|um|mm|m|kg|A|mA|ns|µs|us|ms|s|min|h|Hz|kHz|MB|GB|%|×|cases"
FIGURE = re.compile(
    rf"(?<![\w.^-])(?:\d[\d ]*(?:\.\d+)?(?:e-?\d+)? ?(?:{UNITS})(?!\w)|\d+\.\d+|\d+ of \d+)"
)
"""A number with a unit, a decimal number, a share."""


def figures_in(text: str) -> set[str]:
    """What looks like a result, outside of code, of what is written from results files, and of the
    gateway's tables of faults, falls, margins and drifts, which its own tests write and check."""
    text = render.without_results(text)
    text = re.sub(
        r"<!-- (faults|falls|margins|drifts):.*?<!-- end of \1 -->", "", text, flags=re.DOTALL
    )
    text = re.sub(r"```.*?```|`[^`]*`|\]\([^)]*\)", "", text, flags=re.DOTALL)
    return {figure.strip() for figure in FIGURE.findall(text)}


@pytest.mark.parametrize("path", TEXTS, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_text_says_what_the_results_files_say(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    assert render.rendered(text) == text, "`python -m results.render` writes it"


@pytest.mark.parametrize("path", TYPED, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_text_has_no_figure_of_its_own(path: Path) -> None:
    """Both ways: what is allowed and stands there no more is taken off the list."""
    figures = figures_in(path.read_text(encoding="utf-8"))
    assert figures == set(SPECIFICATIONS.get(path.relative_to(ROOT).as_posix(), {}))


def test_every_figure_and_table_stands_in_a_text() -> None:
    whole = "\n".join(path.read_text(encoding="utf-8") for path in TEXTS)
    assert {match[1] for match in render.TABLE.findall(whole)} == set(TABLES)
    assert {match[1] for match in render.FIGURE.findall(whole)} == set(FIGURES)


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_results_file_says_how_it_was_made(path: Path) -> None:
    provenance = json.loads(path.read_text(encoding="utf-8"))["provenance"]
    assert re.fullmatch(r"[0-9a-f]{40}", provenance["commit"])
    assert provenance["dirty"] is False, "made from code that was not committed"
    assert {"command", "exit", "minutes", "date", "computer"} <= set(provenance)
    assert {"cpu", "cores", "load", "compiler"} <= set(provenance["computer"])


def test_changed_figure_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    growth = {"parameters": [{"name": "10", "median": 2513.0}]}
    results = {"growth": growth, "cases": {"repeatability": {"e": 25.13}}}
    monkeypatch.setattr(render, "content", lambda name: {"results": results})
    text = "e = <!--= repeatability -->25.2<!--/-->\n<!-- table: growth -->\n<!-- /table -->\n"
    lines = render.rendered(text).splitlines()
    assert lines[0] == "e = <!--= repeatability -->25.1<!--/-->"
    assert lines[1] == "<!-- table: growth -->"
    assert lines[4:] == ["| 10 | 2.51 | 25.13 |", "<!-- /table -->"]


def test_unknown_name_and_missing_key_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(ValueError, match="table: none -->: one of"):
        render.rendered("<!-- table: none -->\n<!-- /table -->")
    monkeypatch.setattr(render, "content", lambda name: {"results": {"cases": {}}})
    with pytest.raises(KeyError, match="repeatability"):
        render.rendered("<!--= repeatability -->5.5<!--/-->")


def test_what_was_not_measured_says_so(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(render, "FOLDER", tmp_path)
    render.content.cache_clear()
    text = render.rendered("<!--= missing after -->7.8<!--/-->")
    render.content.cache_clear()
    assert text == "<!--= missing after -->(not measured yet: results/missing.json)<!--/-->"


@pytest.mark.parametrize(
    ("text", "figures"),
    [
        ("falls from 25.1 to 7.8 µrad", {"25.1", "7.8 µrad"}),
        ("takes 14 s and 1 GB, 3 × faster", {"14 s", "1 GB", "3 ×"}),
        ("right in 16 of 21", {"16 of 21"}),
        ("`-d 5.5`, [a](b-1.5.md), six joints, K has 162 parameters", set()),
        ("<!--= missing after -->7.8<!--/-->", set()),
        ("```\n25.1 µrad\n```", set()),
    ],
)
def test_figures_are_recognised(text: str, figures: set[str]) -> None:
    assert figures_in(text) == figures


def test_record_keeps_what_a_command_prints(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(record, "FOLDER", tmp_path)
    path = record.record("one", ["python", "-c", "print('{\"e\": 23.0}')"])
    kept: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    assert kept["results"] == {"e": 23.0}
    assert kept["provenance"]["command"] == "python -c 'print('\"'\"'{\"e\": 23.0}'\"'\"')'"
    assert kept["provenance"]["exit"] == 0


@pytest.mark.parametrize("program", ["print('no figure')", "raise SystemExit(3)"])
def test_record_refuses_what_is_no_result(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, program: str
) -> None:
    monkeypatch.setattr(record, "FOLDER", tmp_path)
    with pytest.raises(ValueError, match="no JSON"):
        record.record("one", ["python", "-c", program])
    assert list(tmp_path.iterdir()) == []

"""The report's experiments stand folded among the details, behind the story."""

from __future__ import annotations

import re
from types import SimpleNamespace

import jinja2
import pytest

from flexhex.experiments import EXPERIMENTS
from flexhex.run.report import TEMPLATES, text_of

FOLDED = ["repeatability", "hysteresis", "payload"]
"""Experiments that no part of the story shows."""


def rendered(table: object) -> str:
    template = jinja2.Environment(autoescape=True).from_string(text_of("sections.html.j2"))
    return template.render(
        run=SimpleNamespace(table=table),
        sections={name: f"text of {name}" for name in EXPERIMENTS},
        titles={name: one.title for name, one in EXPERIMENTS.items()},
    )


@pytest.mark.parametrize(("table", "opened"), [("a table", ""), (None, " open")])
def test_experiments_are_folded_unless_they_are_all_that_was_run(
    table: object, opened: str
) -> None:
    parts = re.findall(
        r'<details class="more"( open)?><summary>(.*?)</summary>\s*text of (\w+)\s*</details>',
        rendered(table),
    )
    assert [name for _, _, name in parts] == FOLDED
    assert [title for _, title, _ in parts] == [EXPERIMENTS[name].title for name in FOLDED]
    assert {state for state, _, _ in parts} == {opened}


def test_details_come_after_the_story() -> None:
    """In the order of the report: loop, answer, assumptions, comparison, causes, details."""
    text = text_of("report.html.j2")
    listed = re.findall(r"<h2>(.*?)</h2>", text)
    assert listed == [
        "The loop",
        "Tracking error",
        "What is assumed",
        "Simulated and published figures",
        "Where the error comes from",
        "Faults",
        "Details",
    ]
    assert text.index('"sections.html.j2"') > text.index("<h2>Details</h2>")
    assert "sections.html.j2" in TEMPLATES

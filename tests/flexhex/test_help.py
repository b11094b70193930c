"""`--help` shows what the commands declare: no unit in brackets is taken for markup."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import pytest
import typer
from typer.testing import CliRunner

from flexhex.cli import app

WIDE = {
    "COLUMNS": "400",
    "TERMINAL_WIDTH": "400",
    "NO_COLOR": "1",
    "_TYPER_FORCE_DISABLE_TERMINAL": "1",
}


def commands() -> dict[str, Any]:
    """All commands by name."""
    group: Any = typer.main.get_command(app)
    return dict(group.commands)


def declared(command: Any) -> Iterator[str]:
    """Help texts of a command and its options, as they are written in the code."""
    yield command.help or ""
    for parameter in (p for p in command.params if not getattr(p, "hidden", False)):
        yield getattr(parameter, "help", None) or ""


def words(text: str) -> str:
    """Without frames, ticks and line breaks."""
    return re.sub(r"[\s│`]+", " ", text)


@pytest.mark.parametrize("name", commands())
def test_help_shows_every_text_as_declared(name: str) -> None:
    shown = CliRunner().invoke(app, [name, "--help"], env=WIDE)
    assert shown.exit_code == 0
    for text in declared(commands()[name]):
        assert words(text) in words(shown.output), text


def test_units_in_brackets_are_among_them() -> None:
    """So that the test above sees what it is for."""
    texts = [text for command in commands().values() for text in declared(command)]
    assert any(re.search(r"\[(s|kg)\]", text) for text in texts)

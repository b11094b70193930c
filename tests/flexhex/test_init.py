"""`flexhex init`: the example is written once, into a Python file."""

from __future__ import annotations

from pathlib import Path

import pytest
from typer.testing import CliRunner

from flexhex.cli import app
from flexhex.fmus.common.errors import OutputError, UsageError
from flexhex.init.command import EXAMPLES, Kind


def test_init_writes_the_example_and_says_how_to_use_it(tmp_path: Path) -> None:
    file = tmp_path / "base.py"
    done = CliRunner().invoke(app, ["init", str(file)])
    assert done.exit_code == 0
    assert file.read_text() == EXAMPLES[Kind.base][0].read_text()
    assert f"--base {file}:TwoLinks" in done.output


def test_init_writes_an_effect_where_the_name_or_the_option_says_so(tmp_path: Path) -> None:
    for words in (["my_effect.py"], ["other.py", "--kind", "effect"]):
        file = tmp_path / words[0]
        done = CliRunner().invoke(app, ["init", str(file), *words[1:]])
        assert file.read_text() == EXAMPLES[Kind.effect][0].read_text()
        assert f"--effect {file}:GasSpring" in done.output


def test_init_replaces_nothing(tmp_path: Path) -> None:
    file = tmp_path / "base.py"
    file.write_text("mine")
    done = CliRunner().invoke(app, ["init", str(file)])
    assert isinstance(done.exception, OutputError)
    assert file.read_text() == "mine"


@pytest.mark.parametrize(
    ("name", "error"), [("base.txt", UsageError), ("none/base.py", OutputError)]
)
def test_init_refuses_other_files(name: str, error: type[Exception], tmp_path: Path) -> None:
    done = CliRunner().invoke(app, ["init", str(tmp_path / name)])
    assert isinstance(done.exception, error)

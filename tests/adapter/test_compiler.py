"""Warnings of the compiler: silent in a user's build, errors in ours."""

from __future__ import annotations

from pathlib import Path

import pytest

from flexhex.fmugen import compile as compiling
from flexhex.fmus.common.errors import BuildError
from tests.adapter import toys


@pytest.fixture
def warning(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A newer compiler: it has something to say about everything, an error under -Werror."""
    real = compiling.compiler()[0]
    program = tmp_path / "newer-cc"
    program.write_text(
        "#!/bin/sh\n"
        'for word in "$@"; do case "$word" in\n'
        '-c) echo "x.c:1: warning: a new one" >&2;;\n'
        '-Werror) echo "x.c:1: error: a new one [-Werror]" >&2; exit 1;;\n'
        f'esac; done\nexec {real} "$@"\n'
    )
    program.chmod(0o755)
    monkeypatch.setenv("CC", str(program))
    monkeypatch.setattr(compiling, "compiler", compiling.compiler.__wrapped__)
    monkeypatch.setattr(compiling, "version", compiling.version.__wrapped__)


@pytest.mark.usefixtures("warning")
def test_warnings_do_not_stop_a_build_and_are_not_shown(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.delenv(compiling.WERROR, raising=False)
    assert toys.build(tmp_path / "fmus").is_file()
    assert capfd.readouterr() == ("", "")


@pytest.mark.usefixtures("warning")
def test_warnings_are_errors_where_wanted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(compiling.WERROR, "1")
    with pytest.raises(BuildError, match="a new one"):
        toys.build(tmp_path / "fmus")


def test_these_tests_run_with_warnings_as_errors() -> None:
    assert "-Werror" in compiling.strict()

"""No file that a command reads is written over."""

from __future__ import annotations

from pathlib import Path

import pytest
from typer.testing import CliRunner

from flexhex.cli import app

RUN = CliRunner()
LOGS = ("a.csv", "b.csv")
CASES = {
    "identify log": (["identify", *LOGS, "--write", "a.csv"], "--write a.csv"),
    "identify held out": (
        ["identify", "a.csv", "--held-out", "b.csv", "-w", "b.csv"],
        "--write b.csv",
    ),
    "identify next": (["identify", *LOGS, "--next", "./b.csv"], "--next b.csv"),
    "identify diagnosis": (
        ["identify", *LOGS, "--diagnosis", "d.json", "-w", "d.json"],
        "--write d",
    ),
    "identify page": (["identify", "identified.html", "-o", "."], "--out identified.html"),
    "diagnose report": (["diagnose", *LOGS, "--report", "b.csv"], "--report b.csv"),
    "diagnose out": (["diagnose", "diagnosis.json", "-o", "."], "--out diagnosis.json"),
    "diagnose base": (
        ["diagnose", *LOGS, "--base", "own.py:X", "--report", "own.py"],
        "--report own",
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_a_file_that_is_read_is_not_written_over(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    words, option = CASES[name]
    text = "time,theta[1],tau_meas[1]\n"
    for file in (*LOGS, "d.json", "own.py", "diagnosis.json", "identified.html"):
        Path(file).write_text(text)
    if "--base" not in words:
        words = [*words, "--base", "axis"]
    done = RUN.invoke(app, words)
    assert getattr(done.exception, "exit_code", None) == 2, done.output
    assert str(done.exception).startswith(option), done.exception
    assert "which is read: name another file" in str(done.exception)
    assert all(Path(file).read_text() == text for file in LOGS)

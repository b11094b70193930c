"""The command `run`: where it writes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from flexhex.cli import app


@pytest.mark.parametrize(
    ("words", "folder"),
    [
        ([], "out"),
        (["--quick"], "out/quick"),
        (["--quick", "--out", "mine"], "mine"),
        (["--out", "mine"], "mine"),
    ],
)
def test_quick_run_leaves_the_files_of_a_full_one(
    words: list[str], folder: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Cases, results, FMUs and report of a run are all in one folder, its own."""
    used: list[Path] = []

    def paper_run(builder: Any, *_: Any) -> None:
        used.append(builder.out)

    def write_report(_: Any, path: Path) -> Path:
        used.append(path)
        return path

    monkeypatch.setattr("flexhex.run.paper.paper_run", paper_run)
    monkeypatch.setattr("flexhex.run.report.write_report", write_report)
    monkeypatch.setattr("flexhex.run.view.print_run", lambda run, report: None)
    done = CliRunner().invoke(app, ["run", *words])
    assert done.exit_code == 0, done.output
    assert used == [Path(folder), Path(folder) / "report.html"]

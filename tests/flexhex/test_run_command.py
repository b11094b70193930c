"""The command `run`: where it writes."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from flexhex.cli import app
from tests.conftest import ROOT

RUN = """
import sys
from flexhex.run import command
assert "numpy" not in sys.modules
try:
    command.run_command(quick=sys.argv[1] == "quick", machine=command.Path("none.toml"))
except Exception:
    pass
import os
print(os.environ["OPENBLAS_NUM_THREADS"])
"""


@pytest.mark.parametrize("length", ["quick", "full"])
def test_run_takes_one_thread_for_linear_algebra(length: str, tmp_path: Path) -> None:
    """Set before NumPy is imported, else it has no effect; the user's own value stays."""
    for given, wanted in ((None, "1"), ("3", "3")):
        own = {} if given is None else {"OPENBLAS_NUM_THREADS": given}
        kept = {k: v for k, v in os.environ.items() if k != "OPENBLAS_NUM_THREADS"}
        done = subprocess.run(
            [sys.executable, "-c", RUN, length],
            cwd=tmp_path,
            env={**kept, "PYTHONPATH": str(ROOT), **own},
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.stdout.split() == [wanted], done.stderr


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

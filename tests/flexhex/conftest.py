"""What tests of commands share: a workflow that answers at once, a browser."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import typer
from typer.testing import CliRunner

import flexhex.diagnose.command as command
import flexhex.diagnose.options as options
from flexhex.diagnosis.logs import Options as LogOptions
from flexhex.diagnosis.result.verdict import Diagnosis
from flexhex.diagnosis.workflow import Options
from tests.flexhex.browser import Browser
from tests.flexhex.diagnoses import BASIC

ADDED = "out/extended.toml"


class Workflow:
    """Stands for diagnosis.workflow and for what adds to a machine file."""

    def __init__(self, diagnosis: Diagnosis) -> None:
        self.answer: Diagnosis | Exception = diagnosis
        self.seen: dict[str, Any] = {}
        self.added = False

    def diagnose(
        self,
        paths: list[Path],
        held_out: list[Path],
        machine_file: Path | None,
        options: Options,
        progress: Callable[[str, int, int], None],
        note: Callable[[str], None],
    ) -> Diagnosis:
        """As the real one is called."""
        self.seen = {
            "paths": paths,
            "held_out": held_out,
            "machine": machine_file,
            "options": options,
        }
        progress("reading the runs", 0, 2)
        progress("fitting", 1, 2)
        if isinstance(self.answer, Exception):
            raise self.answer
        return self.answer

    def add(
        self,
        diagnosis: Diagnosis,
        machine_file: Path,
        out: Path,
        runs: list[Path],
        held_out: list[Path],
        logs: LogOptions,
        say: Callable[[str], None],
    ) -> Diagnosis:
        """As the real one is called."""
        say("building the extended model")
        self.added = True
        return replace(diagnosis, machine=ADDED)


@pytest.fixture
def workflow(monkeypatch: pytest.MonkeyPatch) -> Workflow:
    """A workflow that names Coulomb friction."""
    stand_in = Workflow(BASIC)
    monkeypatch.setattr("flexhex.diagnosis.workflow.diagnose", stand_in.diagnose)
    monkeypatch.setattr("flexhex.diagnose.apply.add", stand_in.add)
    monkeypatch.setattr(
        "flexhex.diagnosis.planning.experiment.with_experiments", lambda diagnosis, *more: diagnosis
    )
    return stand_in


@pytest.fixture
def app() -> typer.Typer:
    """The command as `flexhex.cli` registers it."""
    application = typer.Typer()
    application.command("diagnose", cls=options.Greedy)(command.diagnose_command)
    application.callback()(lambda: None)
    return application


@pytest.fixture
def call(app: typer.Typer, tmp_path: Path) -> Callable[..., Any]:
    """Calls the command with a folder of its own."""

    def called(*words: str, answer: str | None = None) -> Any:
        given = ["diagnose", *words, "--out", str(tmp_path)]
        return CliRunner().invoke(app, given, input=answer)

    return called


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    """One headless Chromium for the tests of a file."""
    opened = Browser(tmp_path_factory.mktemp("profile"))
    yield opened
    opened.close()

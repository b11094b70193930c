"""Every command of the guides either runs here, or stands in a list that says where it does."""

from __future__ import annotations

import re
import shlex
import shutil
from pathlib import Path

import pytest
from typer.testing import CliRunner

from flexhex.cli import app
from flexhex.simulation.builder import Builder
from tests.conftest import ROOT
from tests.diagnosis.test_five_bar import write_log
from tests.studies.test_measured import write_emps
from tests.test_documents import blocks, commands, documents

ELSEWHERE = {
    r"run( --quick| --only payload)?": "tests/flexhex/test_run_cases.py, test_experiments_run.py",
    r"run --machine out/diagnose/machine.toml": "tests/flexhex/test_diagnose_apply.py",
    r"run --quick --machine my.toml .*": "as `run --quick`, on the file of `init` that is checked",
    r"study .*": "tests/flexhex/test_study.py",
    r"build( --platform .*)?": "the FMUs that the other commands take",
    r"view a.csv --live": "tests/flexhex/test_view_live.py",
    r"view .*--base robot.urdf": "tests/flexhex/test_view_robots.py",
    r"identify .*--base (robot.urdf|base.py).*": "tests/flexhex/test_identify_other.py",
    r"diagnose .*--base (robot.urdf|base.py).*": "tests/diagnosis/test_own_base.py, test_robots.py",
    r"diagnose (?!.*(--base|--isolability)).*": "`make missing`, tests/flexhex/test_diagnose.py",
    r"diagnose --isolability plan.*": "tests/flexhex/test_diagnose_experiment.py",
    r"diagnose log1.csv .*": "as that of five-minutes.md, without a held-out run",
    r"(report|compare) out/drive/.*": "tests/gateway/test_drive.py (root)",
    r"check .*out/fmus/\*.fmu.*": "tests/conformity",
    r"export .*(FILE|osp\|cofmupy\|maestro).*": "tests/importers",
}
"""Commands by pattern, and what runs them or one like them."""
CODES = {"diagnose": 1, "compare": 1}
"""Exit codes of what finds something: effects, differences."""


def write_five_bar(folder: Path) -> None:
    """Logs of three motions of the five-bar, under the guide's names."""
    for seed, name in enumerate("abc", 1):
        write_log(folder / f"{name}.csv", seed, friction=0.5, noise=seed)


LOGS = {
    r"identify DATA_EMPS.mat .*": write_emps,
    r"identify a.csv .*--base examples/five_bar/.*": write_five_bar,
}
"""Commands by pattern with logs of another machine than the axis, and what writes such logs."""


def every() -> list[str]:
    """The commands of all guides, once each."""
    guides = [path for path in documents() if path.parent in (ROOT, ROOT / "docs")]
    calls = [words for path in guides for words in commands(path.read_text(encoding="utf-8"))]
    return list(dict.fromkeys(shlex.join(words) for words in calls))


def elsewhere(call: str) -> bool:
    plain = call.replace("'", "")
    return any(re.fullmatch(pattern, plain) for pattern in ELSEWHERE)


@pytest.fixture
def place(call: str, folder: Path, tmp_path: Path) -> Path:
    """Where a command is called: the user's folder, or one with logs of another machine."""
    for pattern, write in LOGS.items():
        if re.fullmatch(pattern, call):
            (tmp_path / "examples").symlink_to(ROOT / "examples")
            (tmp_path / "out").mkdir()
            write(tmp_path)
            return tmp_path
    return folder


@pytest.fixture(scope="module")
def folder(builder: Builder, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A user's folder: examples, machines, FMUs, a quick run, logs under the guides' names."""
    written = tmp_path_factory.mktemp("guides")
    for name in ("examples", "machines"):
        (written / name).symlink_to(ROOT / name)
    done = CliRunner().invoke(app, ["run", "--quick", "--out", str(written / "out")])
    assert done.exit_code == 0, done.output
    (written / "out" / "quick").symlink_to(written / "out")
    (written / "mine.h5").symlink_to(written / "out" / "runs" / "adaptive.h5")
    logs = {"a": "a1", "b": "b1", "c": "c1"} | {n: n for n in ("a1", "a2", "b1", "b2", "c1")}
    for name, log in logs.items():
        shutil.copy(ROOT / "examples" / "axis" / f"{log}.csv", written / f"{name}.csv")
    return written


def test_lists_of_commands_are_needed() -> None:
    """No pattern without a command; something is left to run."""
    plain = [call.replace("'", "") for call in every()]
    idle = [p for p in (*ELSEWHERE, *LOGS) if not any(re.fullmatch(p, call) for call in plain)]
    assert idle == []
    assert sum(not elsewhere(call) for call in every()) > 10


@pytest.mark.slow
@pytest.mark.parametrize("call", [call for call in every() if not elsewhere(call)])
def test_command_of_a_guide_runs(call: str, place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(place)
    opened: list[str] = []
    monkeypatch.setattr("typer.launch", opened.append)
    words = shlex.split(call)
    if words[0] == "init":
        for written in (Path(words[1]), Path(words[1]).with_suffix(".html")):
            written.unlink(missing_ok=True)
    done = CliRunner().invoke(app, words)
    assert done.exit_code == CODES.get(words[0], 0), done.output
    assert len(opened) == words.count("--open")


@pytest.mark.slow
def test_snippet_that_reads_a_run_works(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(folder)
    (snippet,) = blocks((ROOT / "docs" / "look.md").read_text(encoding="utf-8"), "python")
    exec(snippet, {})
    assert capsys.readouterr().out.startswith("10.0 s, largest error ")

"""Times of commands, and the comparison with another revision; no time is asserted here."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from benchmarks import __main__ as command
from benchmarks import against, waits
from benchmarks.against import Change, change
from flexhex.fmus.common.errors import RunError

SPIN = "import time\nwhile time.process_time() < 0.2: pass"


def git(folder: Path, *arguments: str) -> str:
    """Output of git in a folder."""
    own = ["-c", "user.name=t", "-c", "user.email=t@t"]
    done = subprocess.run(
        ["git", *own, *arguments], cwd=folder, capture_output=True, text=True, check=True
    )
    return done.stdout.strip()


@pytest.fixture
def repository(tmp_path: Path) -> Path:
    """A repository of two commits, `one` and `two` in its file."""
    folder = tmp_path / "repository"
    folder.mkdir()
    git(folder, "init", "--quiet")
    for text in ("one", "two"):
        (folder / "file").write_text(text)
        git(folder, "add", "file")
        git(folder, "commit", "--quiet", "-m", text)
    return folder


def test_processor_time_is_that_of_the_command_and_its_children(tmp_path: Path) -> None:
    child = f"import subprocess, sys; subprocess.run([sys.executable, '-c', {SPIN!r}])"
    taken = waits.processor_time([sys.executable, "-c", child], tmp_path, {})
    assert 0.2e9 < taken < 2e9
    sleeping = waits.processor_time(
        [sys.executable, "-c", "import time; time.sleep(1)"], tmp_path, {}
    )
    assert sleeping < 0.8e9, "waiting is not work"


def test_a_command_that_fails_is_reported(tmp_path: Path) -> None:
    with pytest.raises(RunError, match=r"exit 1: (?s:.*)NameError"):
        waits.processor_time([sys.executable, "-c", "no_such_name"], tmp_path, {})


def test_slower_is_what_is_slower_in_the_median_and_at_best() -> None:
    assert change("k", "what", [10, 11, 10], [12, 13, 12]) == Change("k", "what", 10, 12, 1.2)
    assert change("k", "what", [10, 11, 10], [12, 13, 12]).worse
    assert not change("k", "what", [10, 11, 10], [11, 12, 11]).worse
    assert not change("k", "what", [10, 10, 10], [10, 30, 30]).worse, "other work"
    assert not change("k", "what", [10, 30, 30], [12, 30, 30]).worse, "other work"


def test_worktree_holds_the_other_revision_and_goes(repository: Path) -> None:
    with against.worktree(against.commit("HEAD~1", repository), repository) as tree:
        assert (tree / "file").read_text() == "one"
    assert not tree.exists()
    assert len(git(repository, "worktree", "list").splitlines()) == 1


def test_recorded_is_the_commit_of_the_results_file(repository: Path) -> None:
    (repository / "results").mkdir()
    first = git(repository, "rev-parse", "HEAD~1")
    (repository / against.SPEED).write_text(json.dumps({"provenance": {"commit": first}}))
    assert against.commit("recorded", repository) == first


@pytest.mark.parametrize("revision", ["nonsense", "0" * 40])
def test_a_revision_that_is_not_there_is_reported(repository: Path, revision: str) -> None:
    with pytest.raises(RunError, match=f"--against {revision}: no commit .* in this repository"):
        against.commit(revision, repository)


@pytest.mark.parametrize(("now", "status"), [(1.2, 1), (1.1, 0)])
def test_command_fails_on_what_has_become_slower(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], now: float, status: int
) -> None:
    requests = []

    def compare(revision: str, keys: list[str]) -> list[Change]:
        requests.append((revision, keys))
        return [Change("N", "N step", 1e3, now * 1e3, now)]

    monkeypatch.setattr(against, "compare", compare)
    assert command.main(["--against", "HEAD"]) == status
    assert requests == [("HEAD", [*against.BLOCKS, *against.WAITS])]
    assert ("yes" in capsys.readouterr().out) == (status == 1)


def test_a_benchmark_is_measured_in_its_own_tree(tmp_path: Path) -> None:
    """The other tree's own benchmarks measure the other tree."""
    package = tmp_path / "benchmarks"
    package.mkdir()
    (package / "__init__.py").touch()
    row = {"what": "theirs", "timings": [{"median": 7.0}]}
    (package / "__main__.py").write_text(f"print({json.dumps(json.dumps({'rows': [row]}))})")
    assert against.measured("N", tmp_path) == ("theirs", 7.0)


def test_every_command_has_a_row() -> None:
    assert set(waits.COMMANDS) < set(command.ROWS)
    assert set(against.WAITS) < set(waits.COMMANDS)
    assert set(command.LONG) < set(command.ROWS)
    assert not set(command.LONG) & set(against.WAITS)


def test_a_wait_by_the_clock_has_all_cores_and_counts_sleep(tmp_path: Path) -> None:
    (tmp_path / "sleep.py").write_text(
        "import os, time\ntime.sleep(0.5)\nopen('cores', 'w').write(repr(os.sched_getaffinity(0)))"
    )
    sleeping = waits.Command("sleep", "sleep.py", 1.0, clock=True, program=(sys.executable,))
    before = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {min(before)})
    try:
        taken = waits.spent(sleeping, tmp_path)
        assert os.sched_getaffinity(0) == {min(before)}
    finally:
        os.sched_setaffinity(0, before)
    assert taken > 0.5e9
    assert (tmp_path / "cores").read_text() == repr(before)

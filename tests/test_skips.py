"""The list of allowed skips: what is not on it fails the run, also where xdist runs the tests."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.skips import LIST, THERE, Allowed, read

ROOT = Path(__file__).resolve().parent.parent
CONFTEST = """
from pathlib import Path
from tests.skips import Skips, read
def pytest_configure(config):
    config.pluginmanager.register(Skips(read(Path(__file__).with_name("allowed.toml"))))
"""
ALLOWED = """
[[allowed]]
tests = "test_*.py::*"
says = "no such tool"
without = ["program no-such-tool"]
because = "the tool is not there"
[[allowed]]
tests = "test_*.py::*"
says = "no shell"
without = ["program sh"]
because = "there is no shell"
[[allowed]]
tests = "test_*.py::*"
says = "no network"
on_ci = false
because = "there is no network"
"""
PASSES = "def test_passes() -> None:\n    assert True\n"


def skipping(message: str) -> str:
    """A test file with one test that skips."""
    return f"import pytest\n\ndef test_skips() -> None:\n    pytest.skip({message!r})\n"


def run(folder: Path, text: str, *options: str, ci: bool = False) -> tuple[int, str]:
    """Exit code and words of pytest with a second, passing test file."""
    files = {"conftest.py": CONFTEST, "allowed.toml": ALLOWED, "pytest.ini": "[pytest]\n"}
    for name, words in (files | {"test_one.py": text, "test_two.py": PASSES}).items():
        (folder / name).write_text(words)
    environment = {k: v for k, v in os.environ.items() if k != "CI"} | {"PYTHONPATH": str(ROOT)}
    environment["PYTEST_DISABLE_PLUGIN_AUTOLOAD"] = "1"
    plugins = ["-p", "no:cacheprovider", *(["-p", "xdist"] if options else [])]
    command = [sys.executable, "-m", "pytest", "-q", *plugins, *options]
    done = subprocess.run(
        command,
        cwd=folder,
        env=environment | ({"CI": "true"} if ci else {}),
        capture_output=True,
        text=True,
        check=False,
    )
    return done.returncode, done.stdout


@pytest.mark.parametrize("options", [(), ("-n", "1")], ids=["here", "xdist"])
def test_skip_that_is_not_on_the_list_fails(tmp_path: Path, options: tuple[str, ...]) -> None:
    code, said = run(tmp_path, skipping("I do not feel like it"), *options)
    assert code == 1
    assert "1 passed, 1 skipped" in said, "nothing else failed"
    assert "test_one.py::test_skips: Skipped: I do not feel like it" in said


def test_skip_on_the_list_passes_and_is_said(tmp_path: Path) -> None:
    code, said = run(tmp_path, skipping("no such tool"), "-n", "1")
    assert code == 0
    assert "skipped 1 of test_*.py::*: the tool is not there" in said


def test_skip_for_want_of_a_tool_that_is_there_fails(tmp_path: Path) -> None:
    code, said = run(tmp_path, skipping("no shell"))
    assert code == 1
    assert "test_one.py::test_skips: Skipped: no shell" in said


def test_what_ci_must_not_skip_fails_there_alone(tmp_path: Path) -> None:
    assert run(tmp_path, skipping("no network"))[0] == 0
    assert run(tmp_path, skipping("no network"), ci=True)[0] == 1


@pytest.mark.parametrize("options", [(), ("-n", "1")], ids=["here", "xdist"])
def test_file_that_skips_as_a_whole_fails(tmp_path: Path, options: tuple[str, ...]) -> None:
    text = "import pytest\n\npytest.skip('not today', allow_module_level=True)\n"
    code, said = run(tmp_path, text, *options)
    assert code == 1
    assert "test_one.py: Skipped: not today" in said


def test_expected_failure_is_no_skip(tmp_path: Path) -> None:
    text = "import pytest\n\n@pytest.mark.xfail\ndef test_fails() -> None:\n    assert False\n"
    assert run(tmp_path, text)[0] == 0


def test_failure_stays_a_failure(tmp_path: Path) -> None:
    text = skipping("no such tool") + "\ndef test_fails() -> None:\n    assert False\n"
    assert run(tmp_path, text)[0] == 1


def test_every_entry_of_the_list_is_of_a_test_file_and_gives_a_reason() -> None:
    files = [str(p.relative_to(ROOT)) for p in sorted((ROOT / "tests").rglob("test_*.py"))]
    rules = read(LIST)
    assert rules
    for rule in rules:
        covered = [file for file in files if Allowed(rule.tests, "", "").allows(f"{file}::x", "")]
        assert covered, f"{rule.tests}: there are no such tests"
        assert len(rule.because) > 10, rule
        assert {thing.partition(" ")[0] for thing in rule.without} <= set(THERE), rule

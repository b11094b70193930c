"""Skipped tests: each must be on the list `allowed_skips.toml`, else the run fails."""

from __future__ import annotations

import importlib.util
import os
import re
import shutil
import tomllib
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path

import pytest

LIST = Path(__file__).with_name("allowed_skips.toml")
THERE: dict[str, Callable[[str], bool]] = {
    "program": lambda name: shutil.which(name) is not None,
    "module": lambda name: importlib.util.find_spec(name) is not None,
    "variable": lambda name: name in os.environ,
    "user": lambda name: name == "root" and os.geteuid() == 0,
}
"""Kind of a thing that a test needs -> whether it is there."""


@dataclass(frozen=True)
class Allowed:
    """A skip that is no failure.

    tests: pattern of the tests' names; says: regular expression found in the skip's message;
    because: why nothing is lost that the run promises; without: what must be missing, any of
    `kind name` (kinds of THERE; none: whatever is there); on_ci: whether CI may skip it too.
    """

    tests: str
    says: str
    because: str
    without: tuple[str, ...] = ()
    on_ci: bool = True

    def allows(self, test: str, message: str) -> bool:
        """Whether it covers this skip, here and now."""
        if not fnmatchcase(test, self.tests) or not re.search(self.says, message):
            return False
        if not self.on_ci and os.environ.get("CI"):
            return False
        return not self.without or any(missing(thing) for thing in self.without)


def missing(thing: str) -> bool:
    """Whether `kind name` is not there."""
    kind, _, name = thing.partition(" ")
    return not THERE[kind](name)


def read(path: Path) -> list[Allowed]:
    """The list; TypeError for a key that is none."""
    entries = tomllib.loads(path.read_text(encoding="utf-8"))["allowed"]
    return [Allowed(**{**e, "without": tuple(e.get("without", ()))}) for e in entries]


class Skips:
    """The plugin: gathers what was skipped and fails the run where that is not allowed."""

    def __init__(self, allowed: list[Allowed]) -> None:
        self.allowed = allowed
        self.expected: Counter[Allowed] = Counter()
        self.wrong: list[str] = []

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """A test; xdist calls this for the tests of its workers too."""
        if not hasattr(report, "wasxfail"):
            self._note(report)

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        """A file that skips while it is loaded."""
        self._note(report)

    def _note(self, report: pytest.TestReport | pytest.CollectReport) -> None:
        if not report.skipped:
            return
        message = str(report.longrepr[2] if isinstance(report.longrepr, tuple) else report.longrepr)
        rule = next((a for a in self.allowed if a.allows(report.nodeid, message)), None)
        if rule:
            self.expected[rule] += 1
        else:
            self.wrong.append(f"{report.nodeid}: {message}")

    @pytest.hookimpl(trylast=True)
    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        """Fail the run; a worker process leaves that to the one that reports."""
        if self.wrong and not hasattr(session.config, "workerinput") and not session.exitstatus:
            session.exitstatus = pytest.ExitCode.TESTS_FAILED

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        """What was skipped, and why that is allowed or not."""
        for rule, count in self.expected.items():
            terminalreporter.write_line(f"skipped {count} of {rule.tests}: {rule.because}")
        if self.wrong:
            terminalreporter.section(f"skipped, but not allowed by {LIST.name}", red=True)
            for line in self.wrong:
                terminalreporter.write_line(line)

"""Large suites in samples: `make test` runs cases drawn with a seed of the day, `--all` runs all.

A parametrised test is marked `@pytest.mark.sample(4)`: four of its cases are run. Several tests
share a sample by its name: of all marked `sample(2, of="hexapod")` two are run, cases of two tests
where there are two; with `together=True` the tests of a file count as one. A test that goes through
many cases itself draws them by `draw`. What is dear one by one is listed in `sampled.toml`, in
groups of which some are run. The seed is the date, or FLEXHEX_SEED. A test named by its full name
(`file.py::test`) is run whether it is drawn or not.
"""

from __future__ import annotations

import datetime
import os
import random
import tomllib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from itertools import zip_longest
from pathlib import Path
from typing import Any, TypeVar

import pytest

SEED = "FLEXHEX_SEED"
"""Environment variable with the date whose sample is run."""
ALL = "FLEXHEX_ALL"
"""Environment variable that `--all` sets, for the worker processes and for `draw`."""
COUNT = "flexhex_not_drawn"
LIST = Path(__file__).with_name("sampled.toml")

Item = TypeVar("Item")


def seed() -> str:
    """The seed of this session: a date."""
    return os.environ[SEED]


def complete() -> bool:
    """Whether everything is run."""
    return os.environ.get(ALL) == "1"


def draw(cases: Sequence[Item], count: int, of: str) -> list[Item]:
    """`count` of the cases in their order, or all of them with `--all`.

    of: a name, so that several samples of a day are independent of each other.
    """
    if complete() or count >= len(cases):
        return list(cases)
    chosen = random.Random(f"{seed()} {of}").sample(range(len(cases)), count)
    return [cases[k] for k in sorted(chosen)]


@dataclass(frozen=True)
class Group:
    """Tests of which some are run.

    of: its name; run: how many; tests: patterns of their names, without parameters; together: the
    tests of a file count as one, as what they share costs most.
    """

    of: str
    run: int
    tests: tuple[str, ...] = ()
    together: bool = False

    def holds(self, test: str) -> bool:
        """Whether a test of this name is one of them."""
        name = test.partition("[")[0]
        return any(fnmatchcase(name, pattern) for pattern in self.tests)


def read(path: Path) -> list[Group]:
    """The list; TypeError for a key that is none."""
    groups = tomllib.loads(path.read_text(encoding="utf-8"))["group"]
    return [Group(**{**group, "tests": tuple(group["tests"])}) for group in groups]


class Sampling:
    """The plugin: takes from a session what is not drawn, and says so at its end."""

    def __init__(self, config: pytest.Config, listed: Sequence[Group] = ()) -> None:
        self.left_out = 0
        self.listed = listed
        self.known: dict[str, Group | None] = {}
        self.by_name = any("::" in word for word in config.args)
        # the worker processes of xdist inherit both
        os.environ.setdefault(SEED, datetime.date.today().isoformat())
        if config.getoption("--all"):
            os.environ[ALL] = "1"

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(
        self, config: pytest.Config, items: list[pytest.Item]
    ) -> None:
        """Deselect slow tests and cases that are not drawn: by the list, then by their marks."""
        if complete() or self.by_name:
            return
        quick = [item for item in items if not item.get_closest_marker("slow")]
        chosen = set(drawn(drawn(quick, self._group), marked))
        left_out = [item for item in items if item not in chosen]
        items[:] = [item for item in items if item in chosen]
        self.left_out = len(left_out)
        config.hook.pytest_deselected(items=left_out)

    def _group(self, item: pytest.Item) -> Group | None:
        """The first of the list that names a test; the cases of a test are looked up once."""
        name = item.nodeid.partition("[")[0]
        if name not in self.known:
            self.known[name] = next((group for group in self.listed if group.holds(name)), None)
        return self.known[name]

    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        """Hand the count of a worker process to the one that reports."""
        output: dict[str, Any] | None = getattr(session.config, "workeroutput", None)
        if output is not None:
            output[COUNT] = self.left_out

    @pytest.hookimpl(optionalhook=True)
    def pytest_testnodedown(self, node: Any) -> None:
        """Take the count of a worker process; all have the same."""
        self.left_out = getattr(node, "workeroutput", {}).get(COUNT, self.left_out)

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        """The seed, by which a failure can be repeated."""
        if not complete():
            terminalreporter.write_line(
                f"sample of {seed()}: {self.left_out} tests not drawn or slow;"
                f" {SEED}={seed()} repeats this sample, `make test-all` runs everything"
            )


def marked(item: pytest.Item) -> Group | None:
    """The sample of a test's own mark: of that name, else of the cases of its function."""
    mark = item.get_closest_marker("sample")
    if mark is None:
        return None
    name = mark.kwargs.get("of") or item.nodeid.partition("[")[0]
    return Group(name, mark.args[0], together=mark.kwargs.get("together", False))


def drawn(
    items: Sequence[pytest.Item], group_of: Callable[[pytest.Item], Group | None]
) -> list[pytest.Item]:
    """What is drawn of each group, and all that belong to none."""
    groups: dict[Group | None, list[pytest.Item]] = {}
    for item in items:
        groups.setdefault(group_of(item), []).append(item)
    return [
        item
        for group, cases in groups.items()
        for item in (cases if group is None else sample(group, cases))
    ]


def sample(group: Group, cases: Sequence[pytest.Item]) -> list[pytest.Item]:
    """What is drawn of the tests of a group."""
    units: dict[str, list[pytest.Item]] = {}
    for case in cases:
        units.setdefault(str(case.path) if group.together else case.nodeid, []).append(case)
    chosen = spread(list(units), group.run, group.of)
    return [case for unit, own in units.items() if unit in chosen for case in own]


def spread(names: Sequence[str], count: int, of: str) -> set[str]:
    """`count` of the cases `test[case]`, of as many tests as that allows."""
    tests: dict[str, list[str]] = {}
    for name in names:
        tests.setdefault(name.partition("[")[0], []).append(name)
    generator = random.Random(f"{seed()} {of}")
    rows = [generator.sample(cases, len(cases)) for cases in tests.values()]
    generator.shuffle(rows)
    in_turn = [case for turn in zip_longest(*rows) for case in turn if case is not None]
    return set(in_turn[:count])

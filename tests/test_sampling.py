"""Samples of large suites: drawn by date, the same on every process, complete with `--all`."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.sampling import ALL, LIST, SEED, Group, draw, read, spread

ROOT = Path(__file__).resolve().parent.parent
CONFTEST = """
from tests.sampling import Group, Sampling
def pytest_addoption(parser):
    parser.addoption("--all", action="store_true")
def pytest_configure(config):
    config.addinivalue_line("markers", "slow")
    config.addinivalue_line("markers", "sample")
    listed = [Group("dear", 2, ("test_some.py::test_dear_*",))]
    config.pluginmanager.register(Sampling(config, listed))
"""
TESTS = """
import pytest

@pytest.mark.sample(3)
@pytest.mark.parametrize("k", range(40))
def test_many(k):
    pass

@pytest.mark.sample(1, of="pair")
def test_pair_a():
    pass

@pytest.mark.sample(1, of="pair")
def test_pair_b():
    pass

@pytest.mark.sample(1, of="file", together=True)
def test_with_a():
    pass

@pytest.mark.sample(1, of="file", together=True)
def test_with_b():
    pass

def test_dear_a():
    pass

@pytest.mark.parametrize("k", range(2))
def test_dear_b(k):
    pass

@pytest.mark.sample(1)
@pytest.mark.parametrize("k", range(2))
def test_dear_c(k):
    pass

def test_always():
    pass

@pytest.mark.slow
def test_slow():
    pass
"""


def ran(folder: Path, *words: str, date: str = "2026-01-02") -> tuple[list[str], str]:
    """Names of the tests that a session runs, in their order, and all it says."""
    (folder / "conftest.py").write_text(CONFTEST)
    (folder / "test_some.py").write_text(TESTS)
    (folder / "pytest.ini").write_text("[pytest]\n")
    kept = {name: value for name, value in os.environ.items() if name not in (SEED, ALL)}
    environment = kept | {"PYTHONPATH": str(ROOT)} | ({SEED: date} if date else {})
    environment["PYTEST_DISABLE_PLUGIN_AUTOLOAD"] = "1"
    plugins = ["-p", "no:cacheprovider", *(["-p", "xdist"] if "-n" in words else [])]
    command = [sys.executable, "-m", "pytest", "-v", *plugins, *words]
    done = subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    elements = set(re.findall(r"test_some\.py::(\S+)", done.stdout))
    return sorted(elements), done.stdout


def test_sample_is_drawn_by_date_and_said(tmp_path: Path) -> None:
    first, said = ran(tmp_path)
    assert len(first) == 9
    assert len([name for name in first if name.startswith("test_dear")]) == 2, "of the list"
    assert {"test_with_a", "test_with_b"} <= set(first)
    assert len({"test_pair_a", "test_pair_b"} & set(first)) == 1
    assert "test_always" in first
    assert "test_slow" not in first
    assert "sample of 2026-01-02: 42 tests not drawn or slow; FLEXHEX_SEED=2026-01-02" in said
    assert ran(tmp_path)[0] == first, "not repeatable"
    others = [ran(tmp_path, date=f"2026-01-{day:02}")[0] for day in (3, 4)]
    assert any(other != first for other in others)


def test_workers_draw_the_same_sample_and_say_it(tmp_path: Path) -> None:
    tests, said = ran(tmp_path, "-n", "2")
    assert tests == ran(tmp_path)[0]
    assert "sample of 2026-01-02: 42 tests not drawn or slow" in said


def test_seed_is_the_date_of_the_day(tmp_path: Path) -> None:
    assert re.search(r"sample of \d{4}-\d\d-\d\d: 42", ran(tmp_path, date="")[1])


def test_everything_is_run_with_all_or_by_name(tmp_path: Path) -> None:
    tests, said = ran(tmp_path, "--all", "-n", "2")
    assert len(tests) == 51
    assert "sample of" not in said
    assert len(ran(tmp_path, "test_some.py::test_many")[0]) == 40
    assert ran(tmp_path, "test_some.py::test_slow")[0] == ["test_slow"]


def test_draw_keeps_order_and_reaches_every_case(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(ALL, raising=False)
    cases, seen = list(range(10)), set()
    for day in range(1, 29):
        monkeypatch.setenv(SEED, f"2026-02-{day:02}")
        chosen = draw(cases, 3, "some")
        assert chosen == sorted(set(chosen))
        assert len(chosen) == 3
        seen |= set(chosen)
    assert seen == set(cases)
    assert draw(cases, 10, "some") == cases
    monkeypatch.setenv(ALL, "1")
    assert draw(cases, 3, "some") == cases


def test_cases_of_a_group_are_of_many_tests(monkeypatch: pytest.MonkeyPatch) -> None:
    many = [f"many[{k}]" for k in range(50)]
    seen = set[str]()
    for day in range(1, 29):
        monkeypatch.setenv(SEED, f"2026-02-{day:02}")
        chosen = spread(["alone", *many, "other"], 2, "some")
        assert len({name.partition("[")[0] for name in chosen}) == 2
        assert chosen == spread(["alone", *many, "other"], 2, "some")
        assert len(spread(many, 3, "some")) == 3
        seen |= chosen
    assert {"alone", "other"} <= seen
    assert len(seen) > 10


def test_every_listed_pattern_names_tests_of_its_group() -> None:
    groups = read(LIST)
    assert len({group.of for group in groups}) == len(groups)
    waiting = [
        f"{path.relative_to(ROOT).as_posix()}::{name}"
        for path in sorted((ROOT / "tests").rglob("test_*.py"))
        for name in re.findall(r"^def (test_\w+)", path.read_text(encoding="utf-8"), re.MULTILINE)
    ]
    for group in groups:
        for pattern in group.tests:
            one = Group("", 1, (pattern,))
            assert any(map(one.holds, waiting)), f"{group.of}: {pattern} is no test"
        waiting = [name for name in waiting if not group.holds(name)]

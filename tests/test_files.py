"""Files under version control: of a size, nothing generated, no name of a computer."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest

from tests.conftest import ROOT

LONGEST = 250
"""Lines of a file that needs no reason; a longer one gives its reason after `Long:`."""
FMI_HEADERS = ROOT / "build" / "runtime" / "fmi2"
"""The standard's own files, as it publishes them."""
SCREEN, WIDTH = 60, 120
"""Lines of a screen, characters in one."""


def tracked() -> list[Path]:
    """Files under version control, no links; skipped in an archive without git."""
    done = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True)
    if done.returncode:
        pytest.skip("not a git checkout")
    paths = [ROOT / line for line in done.stdout.splitlines()]
    return [path for path in paths if path.is_file() and not path.is_symlink()]


PRIVATE_PLACES = (
    r"(?<![\w.])/(home|Users|root|work)/\w",
    r"//(pypi|test\.pypi|files\.pythonhosted|index\.crates|static\.crates)\.\w",
    r"(?<![\w.])(10|192\.168)(\.\d{1,3}){2,3}(:\d+)?/",
)
"""Paths of somebody's computer; addresses of registries, which are a computer's configuration."""


def private_places(text: str) -> list[str]:
    """Such paths and addresses in a text."""
    return [match[0] for pattern in PRIVATE_PLACES for match in re.finditer(pattern, text)]


def test_no_file_names_a_computer_or_a_registry() -> None:
    wrong = {}
    for path in tracked():
        try:
            places = private_places(path.read_text(encoding="utf-8"))
        except UnicodeDecodeError:
            continue
        if places:
            wrong[str(path.relative_to(ROOT))] = places
    assert wrong == {}


def test_private_places_are_seen() -> None:
    assert private_places("see " + "/home" + "/ann/x and https:" + "//pypi." + "org/simple")
    harmless = ("a.b", "root", "c"), ("out", "work", "x"), ("https:", "", "docs.rs")
    assert not any(private_places("/".join(words)) for words in harmless)


def test_readme_of_each_block_fits_a_screen() -> None:
    """It holds the table equation, function, variables, test."""
    readmes = sorted((ROOT / "fmus").glob("*/README.md"))
    assert len(readmes) >= 8
    lengths = {}
    for path in readmes:
        rows = [max(1, -(-len(line) // WIDTH)) for line in path.read_text().splitlines()]
        lengths[str(path.relative_to(ROOT))] = sum(rows)
    assert {name: length for name, length in lengths.items() if length > SCREEN} == {}


def test_lock_files_have_hashes_and_no_addresses() -> None:
    locks = sorted(ROOT.glob("requirements*.lock"))
    assert locks
    for lock in locks:
        text = lock.read_text(encoding="utf-8")
        assert "--hash=sha256:" in text, lock
        assert not re.search(r"https?://", text), lock


def test_nothing_generated_is_tracked() -> None:
    endings = {".so", ".dll", ".o", ".fmu", ".ssp", ".pyc", ".h5"}
    assert [path for path in tracked() if path.suffix in endings] == []


def test_long_files_give_their_reason() -> None:
    written = [p for p in tracked() if p.suffix in {".py", ".c", ".h", ".rs"}]
    written = [p for p in written if FMI_HEADERS not in p.parents]
    long = {}
    for path in written:
        lines = path.read_text(encoding="utf-8").splitlines()
        if len(lines) > LONGEST and not any("Long:" in line for line in lines[:40]):
            long[str(path.relative_to(ROOT))] = len(lines)
    assert long == {}

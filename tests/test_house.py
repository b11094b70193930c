"""The house stays easy to see: imports go one way, and nothing of a machine is committed."""

from __future__ import annotations

import ast
import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
# common -> room -> fmugen -> ssp -> diagnosis -> flexhex: each may import what stands before it
ORDER = ("fmus.common", "fmus", "fmugen", "ssp", "diagnosis", "flexhex")
FOLDERS = {"fmus": "fmus", "fmugen": "build/fmugen", "ssp": "ssp", "diagnosis": "diagnosis"}


def imports(path: Path) -> set[str]:
    """Modules that a file imports, wherever in it."""
    found: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            found.add(node.module)
    return found


def level(module: str) -> int:
    """Place of a module in the order; -1 when it is not ours."""
    for k, name in enumerate(ORDER):
        if module == name or module.startswith(name + "."):
            return k
    return -1


def forbidden(module: str, imported: str) -> bool:
    """Whether `module` must not import `imported`."""
    ours, theirs = level(module), level(imported)
    if theirs < 0:
        return False
    if ours == theirs == 1:  # two rooms
        return module.split(".")[1] != imported.split(".")[1] and imported != "fmus"
    return theirs > ours


def modules() -> list[tuple[str, Path]]:
    """All our Python files by module name."""
    named = []
    for package, folder in FOLDERS.items():
        for path in sorted((ROOT / folder).rglob("*.py")):
            parts = path.relative_to(ROOT / folder).with_suffix("").parts
            named.append((".".join([package, *parts]), path))
    return named


@pytest.mark.parametrize(("module", "path"), modules(), ids=[name for name, _ in modules()])
def test_imports_go_one_way(module: str, path: Path) -> None:
    wrong = sorted(name for name in imports(path) if forbidden(module, name))
    assert not wrong, f"{module} imports {', '.join(wrong)}"


def test_the_rule_forbids_what_it_should() -> None:
    assert forbidden("fmus.plant.step", "fmus.filter.equations")
    assert forbidden("fmus.common.model", "fmus.plant.equations")
    assert forbidden("ssp.read", "flexhex.cli")
    assert not forbidden("flexhex.cli", "ssp.read")
    assert not forbidden("fmus.plant.equations", "fmus.common.model")


def tracked() -> list[Path]:
    """Files under version control; skipped in an archive without git."""
    done = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True)
    if done.returncode:
        pytest.skip("not a git checkout")
    return [ROOT / line for line in done.stdout.splitlines() if (ROOT / line).is_file()]


def test_lock_file_has_hashes_and_no_addresses() -> None:
    text = (ROOT / "requirements.lock").read_text(encoding="utf-8")
    assert "--hash=sha256:" in text
    assert not re.search(r"https?://", text)


def test_nothing_generated_is_tracked() -> None:
    endings = {".so", ".dll", ".o", ".fmu", ".ssp", ".pyc", ".h5"}
    assert [path for path in tracked() if path.suffix in endings] == []


def test_hand_written_files_fit_in_the_head() -> None:
    written = [p for p in tracked() if p.suffix in {".py", ".c", ".h"}]
    long = {str(p.relative_to(ROOT)): len(p.read_text().splitlines()) for p in written}
    assert {name: lines for name, lines in long.items() if lines > 400} == {}

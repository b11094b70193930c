"""Documents do not go stale: links, file names, imports and commands in them are real."""

from __future__ import annotations

import ast
import importlib
import re
import shlex
import subprocess
from pathlib import Path
from typing import Any

import pytest
import typer.main

import flexhex
from flexhex.cli import app

ROOT = Path(__file__).resolve().parent.parent
HISTORY = {"CHANGELOG.md"}
"""Tells of files that were."""
GENERATED = ("out/", "dist/", ".venv/", "~")


def documents() -> list[Path]:
    """Markdown files under version control that describe the present."""
    done = subprocess.run(
        ["git", "ls-files", "*.md"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    return [ROOT / line for line in done.stdout.splitlines() if line not in HISTORY]


DOCUMENTS = documents()
IDS = [str(path.relative_to(ROOT)) for path in DOCUMENTS]


def without_code(text: str) -> str:
    """Markdown without its fenced blocks."""
    return re.sub(r"(?ms)^ *```.*?^ *```", "", text)


def blocks(text: str, language: str) -> list[str]:
    """Fenced blocks of a language."""
    return re.findall(rf"(?ms)^```{language}\n(.*?)^```", text)


def files_named(text: str) -> set[str]:
    """Paths of files in backticks that begin with a folder: `fmus/plant/step.c`, not `step.c`."""
    spans = re.findall(r"`([\w./-]+/[\w.-]+\.(?:py|c|h|md|toml|rs|json|csv|svg))`", text)
    return {span for span in spans if not span.startswith(GENERATED)}


def there(span: str, document: Path) -> bool:
    """Whether a file of that path exists: from the top, or below the document's folder."""
    return (ROOT / span).exists() or any(document.parent.rglob(span))


def commands(text: str) -> list[list[str]]:
    """Calls of flexhex in shell blocks, word by word, without comments and redirections."""
    listed = []
    for block in blocks(text, "sh"):
        for line in block.replace("\\\n", " ").splitlines():
            words = shlex.split(line, comments=True)
            if words and Path(words[0]).name == "flexhex":
                listed.append(words[1:])
    return listed


def wrong_option(words: list[str]) -> str:
    """What of a call does not exist, or nothing."""
    group: Any = typer.main.get_command(app)
    names = [word for word in words if not word.startswith("-")]
    if not names or names[0] not in group.commands:
        return "" if words and words[0] in ("--help", "--version") else f"no command {names[:1]}"
    known = {option for p in group.commands[names[0]].params for option in p.opts}
    given = {word.partition("=")[0] for word in words if re.match(r"--?[a-zA-Z]", word)}
    return ", ".join(sorted(given - known - {"--help"}))


@pytest.mark.parametrize("document", DOCUMENTS, ids=IDS)
def test_links_lead_somewhere(document: Path) -> None:
    text = without_code(document.read_text(encoding="utf-8"))
    targets = {t.partition("#")[0] for t in re.findall(r"\]\(([^)\s]+)\)", text)}
    local = {t for t in targets if t and "://" not in t}
    assert {t for t in local if not (document.parent / t).exists()} == set()


@pytest.mark.parametrize("document", DOCUMENTS, ids=IDS)
def test_named_files_exist(document: Path) -> None:
    named = files_named(without_code(document.read_text(encoding="utf-8")))
    assert {span for span in named if not there(span, document)} == set()


@pytest.mark.parametrize("document", DOCUMENTS, ids=IDS)
def test_imports_of_examples_work(document: Path) -> None:
    """Every `from flexhex... import name` of a Python block."""
    for block in blocks(document.read_text(encoding="utf-8"), "python"):
        for node in ast.walk(ast.parse(block)):
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("flexhex"):
                module = importlib.import_module(str(node.module))
                missing = [a.name for a in node.names if not hasattr(module, a.name)]
                assert not missing, f"{node.module} has no {', '.join(missing)}"
            short = getattr(node, "module", None) or ""
            assert short.split(".")[0] not in {"fmus", "ssp", "diagnosis", "fmugen"}, short


@pytest.mark.parametrize("document", DOCUMENTS, ids=IDS)
def test_commands_of_examples_exist(document: Path) -> None:
    wrong = {
        " ".join(words): wrong_option(words)
        for words in commands(document.read_text(encoding="utf-8"))
    }
    assert {line: what for line, what in wrong.items() if what} == {}


def test_the_checks_see_what_is_wrong(tmp_path: Path) -> None:
    assert files_named("in `fmus/plant/no.c` and `step.c` and `out/x.json`") == {"fmus/plant/no.c"}
    assert not there("fmus/plant/no.c", ROOT / "README.md")
    assert there("fmus/plant/step.c", ROOT / "README.md")
    assert wrong_option(["run", "--nonsense", "-m", "x"]) == "--nonsense"
    assert wrong_option(["fly"]) == "no command ['fly']"
    assert commands("```sh\n.venv/bin/flexhex run --quick  # short\n```") == [["run", "--quick"]]


def test_citation_is_that_of_this_version() -> None:
    """The keys that the format wants, and the version of the package."""
    lines = (ROOT / "CITATION.cff").read_text(encoding="utf-8").splitlines()
    keys = dict(line.split(": ", 1) for line in lines if re.match(r"[\w-]+: ", line))
    assert {"cff-version", "message", "title", "version"} <= set(keys)
    assert "authors:" in lines
    assert keys["version"] == flexhex.__version__

"""The site of `make docs`, without Sphinx: pages, links to headings, generated parts, snippets."""

from __future__ import annotations

import importlib.util
import re
import shlex
import sys
from pathlib import Path
from types import ModuleType

import pytest
import typer.main
from typer.testing import CliRunner

import flexhex
from flexhex.cli import app
from flexhex.fmus.common.machine_file import load_machine
from flexhex.simulation.builder import Builder
from tests.conftest import MACHINE_FILE, ROOT
from tests.test_documents import blocks, commands, without_code

DOCS = ROOT / "docs"
PAGES = {str(path.relative_to(DOCS).with_suffix("")) for path in DOCS.rglob("*.md")}
NOTEBOOKS = {path.stem for path in DOCS.glob("*.ipynb")}
ROOTS = {"index", "decisions/index"}


def script(name: str) -> ModuleType:
    """A script of docs/ as a module."""
    spec = importlib.util.spec_from_file_location(f"docs_{name}", DOCS / f"{name}.py")
    assert spec
    assert spec.loader
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


def entries(page: str) -> list[str]:
    """What the toctrees of a page list, options left out."""
    text = (DOCS / f"{page}.md").read_text(encoding="utf-8")
    lines = [line for block in blocks(text, r"\{toctree\}") for line in block.splitlines()]
    return [line.strip() for line in lines if line.strip() and not line.startswith(":")]


def anchors(text: str) -> set[str]:
    """Anchors of the headings, as MyST makes them."""
    titles = re.findall(r"(?m)^#{1,4} (.*)$", without_code(text))
    plain = [re.sub(r"[^\w\- ]", "", title.strip().lower()) for title in titles]
    return {title.replace(" ", "-") for title in plain}


def test_guides_install_from_the_folder_as_no_index_has_the_package() -> None:
    guides = [*DOCS.glob("*.md"), *DOCS.glob("*.ipynb"), *(ROOT / "examples").rglob("*.md")]
    guides += [ROOT / "README.md", ROOT / "examples" / "robot" / "robot.ipynb"]
    wrong = re.compile(r"pip install '?flexhex")
    assert not [path for path in guides if wrong.search(path.read_text(encoding="utf-8"))]


def test_every_page_stands_in_one_list() -> None:
    listed = entries("index")
    assert len(listed) == len(set(listed))
    assert entries("decisions/index") == ["0*"]
    decisions = {page for page in PAGES if page.startswith("decisions/0")}
    assert set(listed) | ROOTS | decisions == PAGES | NOTEBOOKS
    assert decisions


@pytest.mark.parametrize("page", sorted(PAGES))
def test_links_to_headings_lead_to_one(page: str) -> None:
    path = DOCS / f"{page}.md"
    text = path.read_text(encoding="utf-8")
    for target, anchor in re.findall(r"\]\(([^)\s#:]*)#([^)\s]+)\)", without_code(text)):
        other = (path.parent / target).read_text(encoding="utf-8") if target else text
        assert anchor in anchors(other), f"{target}#{anchor}"


def test_generated_pages_and_drawings_are_up_to_date() -> None:
    """`make docs` writes them anew."""
    reference = script("machine_reference").text()
    assert (DOCS / "machine-file.md").read_text(encoding="utf-8") == reference
    effects = script("effects_reference").text()
    assert (DOCS / "effects.md").read_text(encoding="utf-8") == effects
    drawn = script("draw_frames").drawing(load_machine(MACHINE_FILE))
    assert (DOCS / "frames.svg").read_text(encoding="utf-8") == drawn
    lengths = script("draw_lengths").drawing()
    assert (DOCS / "lengths.svg").read_text(encoding="utf-8") == lengths


def test_drawing_of_lengths_has_every_number_of_init_and_its_default() -> None:
    """The options that begin with a length of the T-Flex stand in the drawing and in the table."""
    drawn, page = (DOCS / "lengths.svg").read_text(), (DOCS / "my-hexapod.md").read_text()
    command = typer.main.get_command(app).commands["init"]  # type: ignore[attr-defined]
    lengths = {p.opts[0]: p.default for p in command.params if isinstance(p.default, float)}
    assert len(lengths) == 7
    for option, default in lengths.items():
        assert f">{option.removeprefix('--')}</text>" in drawn
        assert re.search(rf"`{option}`.*\b{default:g} (m|rad)\b", page), option
    assert list(vars(script("draw_lengths").SHOWN).values()) == list(lengths.values())


def test_reference_of_the_machine_file_has_every_key() -> None:
    """Every key of the T-Flex's file stands in it, with the unit of the file."""
    text = (DOCS / "machine-file.md").read_text(encoding="utf-8")
    for line in MACHINE_FILE.read_text(encoding="utf-8").splitlines():
        if match := re.match(r'(\w+) = \{.*unit = "([^"]+)"', line):
            assert re.search(rf"\| `{match[1]}`[^|]* \| {re.escape(match[2])} \|", text), line


def test_api_reference_has_every_public_name() -> None:
    text = (DOCS / "api-reference.md").read_text(encoding="utf-8")
    listed = re.findall(r"^\.\. auto\w+:: flexhex\.(\w+)$", text, re.M)
    assert sorted(listed) == sorted(set(flexhex.__all__) - {"__version__"})


def test_pictures_of_pages_are_small() -> None:
    pictures = {path.name: path.stat().st_size for path in DOCS.glob("*.png")}
    assert {"hexapod.png", "my-hexapod.png", "arm.png", "diagnosis.png"} <= set(pictures)
    assert max(pictures.values()) <= 150_000


def test_every_picture_stands_on_a_page() -> None:
    text = "".join(page.read_text(encoding="utf-8") for page in DOCS.glob("*.md"))
    pictures = [path.name for kind in ("png", "svg") for path in DOCS.glob(f"*.{kind}")]
    assert [name for name in pictures if f"({name})" not in text] == []


def test_files_shown_in_the_tutorial_begin_so() -> None:
    """Each block of text is the head of a log in examples/axis."""
    text = (DOCS / "five-minutes.md").read_text(encoding="utf-8")
    shown = blocks(text, "text")
    heads = [path.read_text(encoding="utf-8") for path in (ROOT / "examples/axis").glob("*.csv")]
    assert len(shown) == 2
    assert all(any(head.startswith(part) for head in heads) for part in shown)


def test_value_shown_in_the_tutorial_is_one_of_a_machine_file(tmp_path: Path) -> None:
    """The line with a mass of one's own, in the place of the T-Flex's."""
    (line,) = blocks((DOCS / "my-hexapod.md").read_text(encoding="utf-8"), "toml")
    text, count = re.subn(
        r"(?m)^(\[bodies.end_effector\]\n)m = .*\n", r"\1" + line, MACHINE_FILE.read_text()
    )
    assert count == 1
    file = tmp_path / "my.toml"
    file.write_text(text, encoding="utf-8")
    assert load_machine(file).platform.end_effector.m == 3.0


def test_cells_of_the_notebook_run(
    builder: Builder, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """FMUs come out of the cache of the tests."""
    monkeypatch.chdir(tmp_path)
    text = (DOCS / "fmpy.md").read_text(encoding="utf-8")
    cells = blocks(text, r"\{code-cell\}[^\n]*")
    assert len(cells) == 4
    names: dict[str, object] = {}
    for cell in cells:
        exec(cell, names)
    error = names["result"]["feedback.e"]  # type: ignore[index]
    assert abs(error[8000:]).max() < 5e-6
    theirs, ours = names["theirs"], names["ours"]
    assert (theirs["feedback.e[1]"] == ours["feedback.e"][1:161, 0]).all()  # type: ignore[index]


@pytest.mark.parametrize(
    ("page", "codes"),
    [("five-minutes", [1, 0, 1]), ("my-hexapod", [0, 0])],
    ids=["axis", "hexapod"],
)
def test_commands_of_the_tutorials_do_what_they_say(
    page: str, codes: list[int], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In an empty folder with the examples; `run`, which takes a minute, has tests of its own."""
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    monkeypatch.chdir(tmp_path)
    text = (DOCS / f"{page}.md").read_text(encoding="utf-8")
    calls = [words for words in commands(text) if words[0] != "run"]
    done = [CliRunner().invoke(app, words) for words in calls]
    assert [one.exit_code for one in done] == codes, [shlex.join(words) for words in calls]
    # out/mine is what `run` writes
    for promised in re.findall(r"`(out/(?!mine)[\w/]+\.html|my\.html)`", text):
        assert (tmp_path / promised).is_file(), promised

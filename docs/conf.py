"""The site that `make docs` builds from these pages: Sphinx, furo, MyST. It needs no network."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import flexhex

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
project, author, version = "flexhex", "the flexhex project", flexhex.__version__
release, language = version, "en"
extensions = ["myst_nb", "sphinx.ext.autodoc"]
exclude_patterns = ["**.ipynb_checkpoints"]
suppress_warnings = ["myst.header"]  # the pages of the repository begin where they like
html_theme, html_title = "furo", "flexhex"
html_show_sourcelink = html_copy_source = False
html_static_path: list[str] = []
html_show_copyright = False
html_show_search_summary = False  # a page of a disk may not read the others
myst_heading_anchors = 4
nb_execution_mode, nb_execution_in_temp = "force", True
nb_execution_raise_on_error, nb_execution_timeout = True, 900
nb_execution_show_tb = True
nb_execution_excludepatterns = ["robot.ipynb"]  # shown as it is kept; a test runs it
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
autodoc_preserve_defaults = True  # as the code has them: a function has no other text that is short
TAKEN = {"effects": "fmus/common/effects/README.md", "notation": "NOTATION.md"}
"""Pages that stand elsewhere in the repository: page -> file."""
LINK = re.compile(r"(!?)\[([^\]]*)\]\(([^)\s]+)\)")


def inside(text: str, folder: Path) -> str:
    """Markdown whose links lead to pages of the site; others are their text alone.

    folder: where the text stands, from which its links lead.
    """
    elsewhere = {(ROOT / file).resolve(): f"/{page}.md" for page, file in TAKEN.items()}
    notebooks = {path.resolve(): path.stem for path in HERE.glob("*.ipynb")}

    def link(match: re.Match[str]) -> str:
        picture, words, target = match.groups()
        path, _, anchor = target.partition("#")
        if picture or "://" in target or not path:
            return match[0]
        full = (folder / path).resolve()
        if full in notebooks:  # a link in docs/, which MyST would follow out of it
            return f"{{doc}}`{words.strip('`')} </{notebooks[full]}>`"
        page = elsewhere.get(full)
        if page is None and full.is_relative_to(HERE) and full.suffix == ".md":
            page = f"/{full.relative_to(HERE)}"
        if page is None or (anchor and page in elsewhere.values()):
            return words if page is None else f"[{words}]({page})"
        return f"[{words}]({page}{'#' + anchor if anchor else ''})"

    return LINK.sub(link, text)


def read(app: Any, page: str, source: list[str]) -> None:
    """What Sphinx reads instead of a page."""
    path = ROOT / TAKEN[page] if page in TAKEN else HERE / f"{page}.md"
    text = path.read_text(encoding="utf-8") if page in TAKEN else source[0]
    text = inside(text, path.parent)
    # a README begins with the name of its folder
    title = r"\A# (\w)" if page in TAKEN else r"\Z\A"
    source[0] = re.sub(title, lambda match: f"# {match[1].upper()}", text)


def setup(app: Any) -> None:
    """Called by Sphinx."""
    app.connect("source-read", read)

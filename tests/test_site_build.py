"""The site as Sphinx builds it: no warning, nothing from the network.

`make docs` runs its notebook, too.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest

from tests.conftest import ROOT
from tests.flexhex.browser import Browser
from tests.flexhex.conftest import browser

__all__ = ["browser"]


class Links(HTMLParser):
    """Where a page leads, and the places in it to which others may lead."""

    def __init__(self, page: Path) -> None:
        super().__init__()
        self.page, self.targets, self.places = page, list[str](), set[str]()
        self.feed(page.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for name, value in attrs:
            if name == "id" and value:
                self.places.add(value)
            elif name in ("href", "src") and value:
                self.targets.append(value)


def dead(folder: Path) -> list[str]:
    """Links of a built site that lead to no file, or to no place in one; those that leave it are
    for `make links`."""
    pages = {path.resolve(): Links(path) for path in folder.rglob("*.html")}
    lost = []
    for path, page in pages.items():
        for target in page.targets:
            parts = urlsplit(target)
            if parts.scheme or parts.netloc:
                continue
            file = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            there = file.is_file() and (
                not parts.fragment or file not in pages or parts.fragment in pages[file].places
            )
            lost += [] if there else [f"{path.name}: {target}"]
    return lost


def test_links_that_lead_nowhere_are_seen(tmp_path: Path) -> None:
    (tmp_path / "a b.html").write_text(
        '<h1 id="here">A</h1><a href="https://elsewhere.org/x">x</a>'
    )
    (tmp_path / "c.html").write_text(
        '<a href="a%20b.html#here"></a><a href="a%20b.html#there"></a><img src="none.png">'
        '<a href="#gone"></a>'
    )
    found = ["c.html: a%20b.html#there", "c.html: none.png", "c.html: #gone"]
    assert dead(tmp_path) == found


@pytest.mark.slow
def test_site_is_built_without_a_warning_and_needs_no_network(
    tmp_path: Path, browser: Browser
) -> None:
    pytest.importorskip("sphinx", reason="the extra `docs` is not installed")
    pytest.importorskip("myst_nb", reason="the extra `docs` is not installed")
    words = ["-W", "-q", "-b", "html", "-D", "nb_execution_mode=off", "docs", str(tmp_path)]
    done = subprocess.run(
        [sys.executable, "-m", "sphinx", *words], cwd=ROOT, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    index = (tmp_path / "searchindex.js").read_text(encoding="utf-8")
    assert all(word in index for word in ("hysteresi", "gateway", "friction")), "searched offline"
    assert dead(tmp_path) == []
    for page in tmp_path.rglob("*.html"):
        text = page.read_text(encoding="utf-8")
        assert not re.search(r"<(script|img|iframe)[^>]*\ssrc=\"(https?:)?//", text), page
        assert not re.search(r"<link[^>]*\shref=\"(https?:)?//[^>]*stylesheet", text), page
    styles = [path.read_text(encoding="utf-8") for path in tmp_path.rglob("*.css")]
    assert not any(re.search(r"@import|url\(['\"]?(https?:)?//", text) for text in styles)
    (notebook,) = tmp_path.glob("_downloads/*/fmpy.ipynb")
    assert f'href="{notebook.relative_to(tmp_path)}"' in (tmp_path / "fmpy.html").read_text("utf-8")
    cells = json.loads(notebook.read_text("utf-8"))["cells"]
    assert sum(cell["cell_type"] == "code" for cell in cells) == 4
    # searched from the disk: results, and nothing said
    browser.said.clear()
    address = (tmp_path / "search.html").as_uri()
    browser.open(f"{address}?q=hysteresis", wait=False)
    browser.run("new Promise(done => setTimeout(done, 3000))")
    result = browser.run("[...document.querySelectorAll('.search a')].map(a => a.textContent)")
    assert "Finding what the model lacks" in result
    assert browser.said == []

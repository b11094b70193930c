"""The site as Sphinx builds it: no warning, nothing from the network.

`make docs` runs its notebook, too.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.conftest import ROOT
from tests.flexhex.browser import Browser
from tests.flexhex.conftest import browser

__all__ = ["browser"]


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

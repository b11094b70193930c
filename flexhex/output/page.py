"""One HTML page with tables and plots that needs no network; what the smaller reports share."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from importlib import resources
from pathlib import Path

from flexhex.output.plots import Figure


@dataclass(frozen=True)
class Part:
    """A section: its title, a sentence, a table, plots by the id of their place.

    timed: the x axes of the plots are time; zooming into one zooms all of the page. words:
    the table holds no figures to align. small: plots stand side by side where there is room.
    """

    title: str
    text: str = ""
    headings: Sequence[str] = ()
    rows: Sequence[Sequence[str]] = ()
    figures: Mapping[str, Figure] = field(default_factory=dict)
    timed: bool = False
    words: bool = False
    small: bool = False


def write_page(path: Path, title: str, subtitle: str, parts: Sequence[Part]) -> Path:
    """Render the parts to `path`; every text is escaped."""
    import jinja2

    assets = resources.files(__package__)
    environment = jinja2.Environment(autoescape=True, undefined=jinja2.StrictUndefined)
    template = environment.from_string((assets / "page.html.j2").read_text(encoding="utf-8"))
    figures = {name: figure for part in parts for name, figure in part.figures.items()}
    timed = [name for part in parts if part.timed for name in part.figures]
    text = template.render(
        title=title,
        subtitle=subtitle,
        parts=parts,
        figures_json=_script(figures),
        timed_json=_script(timed),
        plotly=plotly_js(),
    )
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    return path


def plotly_js() -> str:
    """The plotting library that stands in every page."""
    return (resources.files(__package__) / "plotly-basic.min.js").read_text(encoding="utf-8")


def _script(data: object) -> str:
    """Data as JavaScript that cannot end the script it stands in."""
    return json.dumps(data).replace("</", "<\\/")

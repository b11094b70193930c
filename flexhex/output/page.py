"""One HTML page with tables and plots that needs no network; what all reports share."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from importlib import resources
from pathlib import Path
from typing import Any

from flexhex.output.glossary import term
from flexhex.output.plots import Figure


@dataclass(frozen=True)
class PageSection:
    """A section: its title, a sentence, a table, plots by the id of their place.

    timed: the x axes of the plots are time; zooming into one zooms all of the page. words:
    the table holds no figures to align. small: plots stand side by side where there is room.
    answer: the sentence is what the page is read for. folded: among the details at the end.
    """

    title: str
    text: str = ""
    headings: Sequence[str] = ()
    rows: Sequence[Sequence[str]] = ()
    figures: Mapping[str, Figure] = field(default_factory=dict)
    timed: bool = False
    words: bool = False
    small: bool = False
    answer: bool = False
    folded: bool = False


def write_page(path: Path, title: str, subtitle: str, parts: Sequence[PageSection]) -> Path:
    """Render the parts to `path`; every text is escaped."""
    figures = {}
    for part in parts:
        for name, figure in part.figures.items():
            figures[name] = linked(figure, "page") if part.timed else figure
            if part.small:
                figures[name] = marked(figures[name], half=True)
    text = page_html("page.html.j2", figures, title=title, subtitle=subtitle, parts=parts)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    return path


def page_html(
    template: str,
    figures: Mapping[str, Figure],
    templates: Mapping[str, str] | None = None,
    **values: Any,
) -> str:
    """A page in the frame that all share: scheme, contents, plots, data behind them, print.

    template: one of `frame/` or of `templates` (name -> text), which extends `frame.html.j2`; it
    needs `title`. figures: by the id of a <div class="plot">, drawn by frame.js.
    """
    import jinja2

    frame = {name: _frame(name) for name in ("frame.html.j2", "page.html.j2")}
    environment = jinja2.Environment(
        loader=jinja2.DictLoader({**frame, **(templates or {})}),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
    )
    text: str = environment.get_template(template).render(
        css=_frame("frame.css"),
        js=_frame("multiples.js") + _frame("frame.js"),
        plotly=plotly_js(),
        figures_json=_script(figures),
        term=term,
        **values,
    )
    return text


def linked(figure: Figure, group: str) -> Figure:
    """The same figure; its x axis is time and is zoomed with those of the same group."""
    return marked(figure, time=group)


def marked(figure: Figure, **meta: Any) -> Figure:
    """The same figure with more for frame.js in `layout.meta`."""
    layout = figure["layout"]
    return {**figure, "layout": {**layout, "meta": {**layout.get("meta", {}), **meta}}}


def plotly_js() -> str:
    """The plotting library that stands in every page."""
    return (resources.files(__package__) / "plotly-basic.min.js").read_text(encoding="utf-8")


def _frame(name: str) -> str:
    return (resources.files(__package__) / "frame" / name).read_text(encoding="utf-8")


def _script(data: object) -> str:
    """Data as JavaScript that cannot end the script it stands in."""
    return json.dumps(data).replace("</", "<\\/")

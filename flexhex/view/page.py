"""The page of `flexhex view`: libraries, our scripts and data in one file."""

from __future__ import annotations

import json
from importlib import resources
from pathlib import Path
from typing import Any

SCRIPTS = (
    "kinematics.js",
    "data.js",
    "colours.js",
    "machine.js",
    "robot.js",
    "scene.js",
    "plots.js",
    "paint.js",
    "live.js",
    "still.js",
    "app.js",
)
"""Our scripts in the order in which they run; they share one scope."""
MODULES = ("three.core.min.js", "three.module.min.js", "OrbitControls.js")
"""ES modules; the page loads them from itself, since a browser imports no file of a disk."""


def write_view(path: Path, title: str, data: dict[str, Any]) -> Path:
    """Write the page."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(view_html(title, data), encoding="utf-8")
    return path


def view_html(title: str, data: Any, live: bool = False) -> str:
    """The page; every text is escaped. live: it asks where it comes from for newer data."""
    import jinja2

    bare = isinstance(data, dict) and data["machine"]["kind"] == "none"
    environment = jinja2.Environment(autoescape=True, undefined=jinja2.StrictUndefined)
    template = environment.from_string(_text("view.html.j2"))
    text: str = template.render(
        title=title,
        live=live,
        styles=[_asset("uPlot.min.css"), _text("view.css")],
        modules={name: script_text(_asset(name)) for name in (() if bare else MODULES)},
        scripts=[script_text(_asset("uPlot.iife.min.js")), *(_text(name) for name in SCRIPTS)],
        data=json_text(data),
    )
    return text


def script_text(text: str) -> str:
    """The same JavaScript, which cannot end the script element that it stands in."""
    return text.replace("</script", "<\\/script")


def json_text(data: Any) -> str:
    """Data as JSON without a `<`, so that no element can begin or end in it."""
    return json.dumps(data, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")


def _text(name: str) -> str:
    return (resources.files(__package__) / "page" / name).read_text(encoding="utf-8")


def _asset(name: str) -> str:
    return (resources.files(__package__) / "assets" / name).read_text(encoding="utf-8")

"""`python -m results.render [--check]`: figures of the texts from results/*.json.

    <!-- table: NAME -->        a table of `figures.TABLES`; lines up to <!-- /table -->
    <!--= NAME -->7.8<!--/-->   a figure of `figures.FIGURES`

What stands between the marks is written anew, and what the package says of its own reliability;
--check only says what differs (1).
"""

from __future__ import annotations

import argparse
import json
import re
from functools import cache
from pathlib import Path
from typing import Any

from results.figures import EVERY, FIGURES, TABLES, Source
from results.record import FOLDER, ROOT
from results.reliability import written

COUNTS = ROOT / "diagnosis" / "result" / "confidence.json"
TABLE = re.compile(r"(<!-- table: (.+?) -->\n)(.*?)(<!-- /table -->)", re.DOTALL)
FIGURE = re.compile(r"(<!--= (.+?) -->)(.*?)(<!--/-->)", re.DOTALL)


def texts() -> list[Path]:
    """The texts whose figures come from results files."""
    return [ROOT / "README.md", FOLDER / "README.md", *sorted((ROOT / "docs").glob("*.md"))]


@cache
def content(name: str) -> dict[str, Any] | None:
    """A results file: `provenance` and `results`; None where it was not measured yet."""
    if name == EVERY:
        names = sorted(path.stem for path in FOLDER.glob("*.json"))
        return {"results": {each: (content(each) or {})["provenance"] for each in names}}
    path = FOLDER / f"{name}.json"
    return json.loads(path.read_text(encoding="utf-8")) if path.exists() else None


def rendered(text: str) -> str:
    """The text with all figures as the results files give them; ValueError for an unknown name."""

    def between(known: dict[str, Source]) -> Any:
        def replaced(match: re.Match[str]) -> str:
            name = match[2]
            if name not in known:
                raise ValueError(f"{match[1].strip()}: one of {', '.join(known)}")
            file = content(known[name].file)
            if file is None:
                shown = f"(not measured yet: results/{known[name].file}.json)\n"
            else:
                shown = known[name].text(file["results"])
            return match[1] + (shown if known is TABLES else shown.strip()) + match[4]

        return replaced

    return FIGURE.sub(between(FIGURES), TABLE.sub(between(TABLES), text))


def without_results(text: str) -> str:
    """The text without what is written from results files."""
    return FIGURE.sub("", TABLE.sub("", text))


def main(arguments: list[str] | None = None) -> int:
    """0; 1 when a text differs and is not to be written."""
    parser = argparse.ArgumentParser(prog="results.render", description=__doc__)
    parser.add_argument("--check", action="store_true", help="write nothing")
    given, differ = parser.parse_args(arguments), []
    wanted = {path: rendered(path.read_text(encoding="utf-8")) for path in texts()}
    if study := content("hidden_effects"):
        wanted[COUNTS] = written(study["results"])
    for path, after in wanted.items():
        before = path.read_text(encoding="utf-8") if path.exists() else ""
        if after != before:
            differ.append(str(path.relative_to(ROOT)))
            if not given.check:
                path.write_text(after, encoding="utf-8")
    print("differed:" if differ else "all as in results/", *differ)
    return 1 if differ and given.check else 0


if __name__ == "__main__":
    raise SystemExit(main())

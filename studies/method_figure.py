"""`python -m studies.method_figure [--generator SEED] [--out FILE]`: docs/method.svg, what the best
hypotheses of every round of a search gain."""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Sequence
from itertools import groupby
from pathlib import Path

from flexhex.diagnosis.result.pictured import Candidate
from flexhex.diagnosis.workflow import Options, diagnose
from studies.families import FAMILIES, refuse

OUT = Path("docs") / "method.svg"
SEED = 8
WIDTH, LEFT, ROW, BAR, HEAD = 760, 300, 20, 13, 30
"""Of the picture, of its names, of a line, of a bar, of a round's title [px]."""
SHOWN = 5
"""Hypotheses of a round."""


def picture(candidates: Sequence[Candidate]) -> str:
    """Bars of the gains, round by round."""
    rounds = [list(own)[:SHOWN] for _, own in groupby(candidates, key=lambda c: c.round)]
    height = sum(HEAD + ROW * len(own) for own in rounds) + 10
    body = []
    y = 0
    for own in rounds:
        y += HEAD
        most = max(max(c.gain for c in own), 1e-9)
        title = f"round {own[0].round}: gain of up to {most:.0f} nats"
        body.append(f'<text x="{LEFT}" y="{y - 10}" font-weight="bold">{title}</text>')
        for c in own:
            body.append(_bar(c, y, most))
            y += ROW
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{height}"'
        f' viewBox="0 0 {WIDTH} {height}" font-family="sans-serif" font-size="12">\n'
        '<defs><pattern id="like" width="6" height="6" patternUnits="userSpaceOnUse">'
        '<rect width="6" height="6" fill="#9db8d6"/>'
        '<path d="M0 6L6 0" stroke="#1f4e8c" stroke-width="1.5"/></pattern></defs>\n'
        '<rect width="100%" height="100%" fill="white"/>\n' + "\n".join(body) + "\n</svg>\n"
    )


def _bar(c: Candidate, y: int, most: float) -> str:
    width = max((WIDTH - LEFT - 150) * c.gain / most, 1.0)
    fill = "#1f4e8c" if c.chosen else "url(#like)" if c.rival else "#d0d4da"
    where = f", axis {c.axes[0]}" if c.axes else ""
    size = f"{c.gain:.0f} nats, {100 * c.size:.2f} %"
    return (
        f'<text x="{LEFT - 8}" y="{y + BAR - 2}" text-anchor="end">{c.id}{where}</text>'
        f'<rect x="{LEFT}" y="{y}" width="{width:.1f}" height="{BAR}" fill="{fill}"/>'
        f'<text x="{LEFT + width + 6:.1f}" y="{y + BAR - 2}">{size}</text>'
    )


def main(arguments: list[str] | None = None) -> int:
    """0."""
    parser = argparse.ArgumentParser(prog="studies.method_figure", description=__doc__)
    parser.add_argument("--generator", type=int, default=SEED, help="seed of the case")
    parser.add_argument("--out", type=Path, default=OUT)
    given = parser.parse_args(arguments)
    refuse(given.generator, False)
    with tempfile.TemporaryDirectory() as logs, tempfile.TemporaryDirectory() as truth:
        case = FAMILIES["generator"](given.generator, Path(logs), Path(truth), None)
        diagnosis = diagnose(case.paths, case.test_paths, case.machine_file, Options())
    given.out.write_text(picture(diagnosis.candidates), encoding="utf-8")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())

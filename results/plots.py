"""`python -m results.plots [--fmus DIR] [--export DIR]`: the plot in each FMU's README, from its
lines of FMPy.

The Python block of `fmus/<name>/README.md` runs as it stands, on the FMUs of `flexhex build` (the
player's on those of the `flexhex export` that stands above it); what its calls of simulate_fmu
return is drawn into `fmus/<name>/plot.svg`. One panel for each array.
"""

from __future__ import annotations

import argparse
import contextlib
import html
import io
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any
from unittest.mock import patch

import fmpy
import numpy as np
from numpy.typing import NDArray

from flexhex.fmugen.blocks import BLOCKS

Array = NDArray[np.float64]
ROOT = Path(__file__).resolve().parent.parent
DRAWN = (*BLOCKS, "machine")
"""FMUs of every build, with a README and a plot."""
EXPORT = "flexhex export out/hexapod.ssp --trajectory examples/motion.csv writes it"
COLOURS = ("#1f6fb2", "#d1731d", "#2e8b57", "#8a4fb0", "#b03a48", "#555555")
LEFT, WIDTH, RIGHT = 78, 440, 152
"""Dots: of the scale, of a panel, of the names of its lines."""
PANEL, GAP, TOP, BOTTOM = 84, 18, 10, 40
"""Dots: height of a panel, between two, above the first, below the last."""
INSET = 5
"""Dots: from the frame to the smallest and the largest value, which stand beside that height."""
POINTS = 220
"""Points of a line: every second dot of a panel, the smallest and largest of each stretch kept."""


@dataclass(frozen=True)
class Line:
    """One scalar over time: name, unit, which call it is from (empty: the only one), t [s]."""

    name: str
    unit: str
    call: str
    t: Array
    values: Array

    @property
    def array(self) -> str:
        """The name without its index."""
        return re.sub(r"\[\d+\]$", "", self.name)

    @property
    def label(self) -> str:
        """What stands beside the line."""
        return f"{self.name}, {self.call}" if self.call else self.name


@dataclass(frozen=True)
class Call:
    """One call of simulate_fmu: path of the FMU, its start values, the rows that it returned."""

    fmu: str
    starts: Mapping[str, float]
    rows: Any

    def differing(self, files: bool) -> str:
        """What tells this call from the others: the FMU, or its start values."""
        if files:
            return Path(self.fmu).name
        if not self.starts:
            return "as it starts"
        name, value = next(iter(self.starts.items()))
        return f"{name.split('[')[0]} = {value:g}"


def calls_of(code: str) -> list[Call]:
    """Run lines of FMPy, without what they print; the calls of simulate_fmu in their order."""
    calls: list[Call] = []
    simulate = fmpy.simulate_fmu

    def recorded(filename: str, **options: Any) -> Any:
        rows = simulate(filename, **options)
        calls.append(Call(filename, options.get("start_values", {}), rows))
        return rows

    with patch.object(fmpy, "simulate_fmu", recorded), contextlib.redirect_stdout(io.StringIO()):
        exec(compile(code, "README.md", "exec"), {})
    return calls


def lines_of(calls: Sequence[Call]) -> list[Line]:
    """Every output of every call."""
    files, lines = len({call.fmu for call in calls}) > 1, []
    for call in calls:
        which = call.differing(files) if len(calls) > 1 else ""
        listed = fmpy.read_model_description(call.fmu).modelVariables
        units = {v.name: v.unit or "1" for v in listed}
        lines += [
            Line(name, units[name], which, call.rows["time"], call.rows[name].astype(float))
            for name in call.rows.dtype.names
            if name != "time"
        ]
    return lines


def drawn(lines: Sequence[Line]) -> str:
    """The plot as SVG: a panel for each array, in the order of the lines."""
    panels: dict[str, list[Line]] = {}
    for line in lines:
        panels.setdefault(line.array, []).append(line)
    height = TOP + len(panels) * (PANEL + GAP) - GAP + BOTTOM
    width = LEFT + WIDTH + RIGHT
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}"'
        ' font-family="sans-serif" font-size="11" fill="#222">',
        f'<rect width="{width}" height="{height}" fill="white"/>',
    ]
    end = max(line.t[-1] for line in lines)
    for k, (array, shown) in enumerate(panels.items()):
        parts += panel(array, shown, TOP + k * (PANEL + GAP), end)
    foot = TOP + len(panels) * (PANEL + GAP) - GAP
    for share in (0.0, 0.5, 1.0):
        x = LEFT + share * WIDTH
        parts.append(text(x, foot + 15, f"{share * end:.3g}", "middle"))
    parts.append(text(LEFT + WIDTH / 2, foot + 31, "time [s]", "middle"))
    return "\n".join([*parts, "</svg>"]) + "\n"


def panel(array: str, lines: Sequence[Line], top: float, end: float) -> list[str]:
    """One panel: frame, smallest and largest value, lines, their names."""
    least = min(float(line.values.min()) for line in lines)
    most = max(float(line.values.max()) for line in lines)
    # a constant is drawn in the middle
    low, high = (least, most) if most > least else (least - 1, most + 1)
    parts = [
        f'<rect x="{LEFT}" y="{top}" width="{WIDTH}" height="{PANEL}" fill="none" stroke="#bbb"/>',
        text(LEFT - 5, top + PANEL / 2 + 4, f"[{lines[0].unit}]", "end", turned=True),
        text(LEFT - 5, top + INSET + 4, f"{high:.3g}", "end"),
        text(LEFT - 5, top + PANEL - INSET + 4, f"{low:.3g}", "end"),
    ]
    for k, line in enumerate(lines):
        colour = COLOURS[k % len(COLOURS)]
        at = thinned(line.values)
        x = LEFT + WIDTH * line.t[at] / end
        y = top + INSET + (PANEL - 2 * INSET) * (high - line.values[at]) / (high - low)
        points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y, strict=True))
        parts.append(f'<polyline points="{points}" fill="none" stroke="{colour}"/>')
        name = text(LEFT + WIDTH + 8, top + 10 + 13 * k, line.label, "start", colour=colour)
        parts.append(name)
    return parts


def thinned(values: Array) -> NDArray[np.int64]:
    """Indices of the samples that a line of `POINTS` points needs."""
    if len(values) <= POINTS:
        return np.arange(len(values))
    edges = np.linspace(0, len(values), POINTS // 2 + 1).astype(int)
    kept = {0, len(values) - 1}
    for first, last in pairwise(edges):
        part = values[first:last]
        kept |= {first + int(part.argmin()), first + int(part.argmax())}
    return np.array(sorted(kept))


def text(
    x: float, y: float, words: str, anchor: str, colour: str = "", turned: bool = False
) -> str:
    """Words at a place; turned: upright along the scale, left of its numbers."""
    fill = f' fill="{colour}"' if colour else ""
    if turned:
        x -= 42
        fill += f' transform="rotate(-90 {x:g} {y:g})"'
        anchor = "middle"
    said = html.escape(words)
    return f'<text x="{x:g}" y="{y:g}" text-anchor="{anchor}"{fill}>{said}</text>'


def plot(name: str, fmus: Path) -> str:
    """The plot of one FMU's README, from the FMUs in a folder."""
    readme = (ROOT / "fmus" / name / "README.md").read_text(encoding="utf-8")
    (code,) = re.findall(r"(?ms)^```python\n(.*?)^```", readme)
    return drawn(lines_of(calls_of(re.sub("out/(fmus|export)", fmus.as_posix(), code))))


def main() -> None:
    """Draw all of them anew."""
    parser = argparse.ArgumentParser(prog="results.plots", description=__doc__)
    parser.add_argument("--fmus", type=Path, default=Path("out/fmus"), help="built FMUs")
    parser.add_argument("--export", type=Path, default=Path("out/export"), help="with the player")
    given = parser.parse_args()
    if not (given.export / "player.fmu").exists():
        parser.error(f"{given.export}/player.fmu is not there: {EXPORT}")
    for name, folder in (*((name, given.fmus) for name in DRAWN), ("player", given.export)):
        path = ROOT / "fmus" / name / "plot.svg"
        path.write_text(plot(name, folder), encoding="utf-8")
        print(path.relative_to(ROOT))


if __name__ == "__main__":
    main()

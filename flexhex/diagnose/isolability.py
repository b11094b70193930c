"""Which effects planned trajectories could show: table, heat map, JSON."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from rich.console import Console

from flexhex.diagnose.numbers import listed, number
from flexhex.diagnose.plots import heat
from flexhex.diagnose.titles import title, where
from flexhex.diagnose.view import titled
from flexhex.diagnosis.planning.isolability import ALIKE, Isolability
from flexhex.output.page import PageSection, write_page
from flexhex.output.parts import Sentence, print_parts, say

MOST_NAMES = 4


def headings(isolability: Isolability) -> tuple[str, ...]:
    """Of the table."""
    return "effect", "where", f"detectable from [{isolability.unit}]", "indistinguishable from"


def rows(isolability: Isolability) -> list[tuple[str, ...]]:
    """An effect a row: where, smallest torque RMS, what it cannot be told from."""
    table: list[tuple[str, ...]] = []
    for k, name in enumerate(isolability.effects):
        rivals = [label(isolability, j) for j in isolability.rivals(k)]
        more = [f"{len(rivals) - MOST_NAMES} more"] if len(rivals) > MOST_NAMES else []
        names = listed([*rivals[:MOST_NAMES], *more])
        smallest = float(isolability.smallest[k])
        least = number(smallest, 2) if math.isfinite(smallest) else "never"
        table.append((title(name), where(isolability.axes[k], short=True), least, names or "–"))
    return table


def label(isolability: Isolability, k: int) -> str:
    """An effect; with its axis where it stands in the matrix more than once."""
    name = title(isolability.effects[k])
    if isolability.effects.count(isolability.effects[k]) == 1:
        return name
    return f"{name}, {where(isolability.axes[k], short=True)}"


def verdict(isolability: Isolability) -> str:
    """How many effects stand alone; and on which axis, where there are several."""
    count = len(isolability.effects)
    alone = [
        k
        for k in range(count)
        if not isolability.rivals(k) and math.isfinite(isolability.smallest[k])
    ]
    unseen = sum(not math.isfinite(v) for v in isolability.smallest)
    text = f"{len(alone)} of {count} effects could be identified alone"
    if len(alone) + unseen < count:
        text += f", {count - len(alone) - unseen} only together with indistinguishable ones"
    text += f", {unseen} would not be detected." if unseen else "."
    if isolability.n == 1:
        return text
    return (
        f"{text} Shown for axis {isolability.axis}, which moves most of the {isolability.n} axes."
    )


def print_isolability(isolability: Isolability, page: Path) -> None:
    """The answer in a line, the table, where the page is."""
    out = Console()
    told = titled(
        "Effects that these trajectories could reveal", headings(isolability), rows(isolability)
    )
    print_parts(out, [Sentence(verdict(isolability), "bold"), told])
    say(out, f"report   {page}")


def isolability_json(isolability: Isolability, page: Path) -> str:
    """The matrix for a program."""
    data = {**isolability.data(), "sentence": verdict(isolability), "report": str(page)}
    return json.dumps(data, indent=2, allow_nan=False)


def write_isolability(isolability: Isolability, trajectories: Sequence[str], path: Path) -> Path:
    """The page: heat map and table."""
    names = [label(isolability, k) for k in range(len(isolability.effects))]
    share = np.fmax(isolability.share, isolability.share.T)
    drawn = {"matrix": heat("", names, names, share)}
    text = (
        f"{verdict(isolability)} A cell is the share of one effect's torque that another could"
        f" reproduce [%]. From {100 * ALIKE:.0f} % on the two are indistinguishable here."
    )
    parts = [
        PageSection("Which effects could be distinguished", text, figures=drawn),
        PageSection("Smallest effects", "", headings(isolability), rows(isolability), words=True),
    ]
    return write_page(
        path, "Effects that these trajectories could reveal", ", ".join(trajectories), parts
    )

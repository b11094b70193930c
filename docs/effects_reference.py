"""Writes docs/effects.md from the library of effects.

python docs/effects_reference.py
"""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from pathlib import Path

from flexhex.fmus.common.effects import Effect, library

HERE = Path(__file__).resolve().parent
HEAD = """# Effects
All effects that the diagnosis searches, and that a machine file, the plant, the feedforward and the
estimator may have. `docs/effects_reference.py` writes this page from the library. How each works,
and how to add one of your own, stands in
[`fmus/common/effects/README.md`](../fmus/common/effects/README.md).

θ, its rate and its acceleration are `theta`, `thetad`, `thetadd`; τ is `tau`, the torque that the
drive reports. Units are those of a rotary axis: on a linear one read m for rad, N for N m, kg for
kg m2. *Shape*: a parameter that is not linear. What looks alike in your runs is told apart by the
motion in the third column.
"""
GROUPS = {
    "torque": "The joint needs this torque more",
    "drive": "The drive reports this torque more than the joint gets",
    "measurement": "The encoder reads this more than the angle",
    "mechanism": "Another model",
}
COLUMNS = ("effect", "parameters", "shows in", "may be taken for")


def _parameters(effect: Effect) -> Iterator[str]:
    for gain in effect.gains:
        yield f"`{gain.name}` [{gain.unit}] {gain.description}"
    for shape in (own for own in effect.shapes if not own.aside):
        yield f"shape `{shape.name}` [{shape.unit}] {shape.description}"


def _row(effect: Effect) -> str:
    adds = (inspect.getdoc(effect) or "").split("\n\n")[0].replace("\n", " ")
    cells = (
        f"`{effect.id}`, {effect.title}: {adds}",
        "; ".join(_parameters(effect)),
        effect.excites,
        ", ".join(f"`{other}`" for other in effect.confused_with),
    )
    return f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |"


def text() -> str:
    """The whole page."""
    lines = [HEAD]
    for place, title in GROUPS.items():
        own = [effect for effect in library().values() if effect.acts_on == place]
        lines += [f"## {title}", f"| {' | '.join(COLUMNS)} |", "|" + " --- |" * len(COLUMNS)]
        lines += [*map(_row, own), ""]
    return "\n".join(lines).rstrip() + "\n"


if __name__ == "__main__":
    (HERE / "effects.md").write_text(text(), encoding="utf-8")

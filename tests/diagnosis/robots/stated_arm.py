"""The arm of `examples/robot` with friction in its file and effects in the TOML beside it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from flexhex.diagnosis.basemodels.bases import base_of
from flexhex.diagnosis.basemodels.robots import RobotBase
from flexhex.diagnosis.logs import Log
from tests.conftest import ROOT

EXAMPLE = ROOT / "examples" / "robot"
RUNS = tuple(EXAMPLE / f"{name}.csv" for name in ("a1", "a2", "b1", "b2"))
HELD_OUT = (EXAMPLE / "c1.csv",)
DRY, VISCOUS, RIPPLE, PER_TURN = (0.8, 1.5, 0.5), (0.6, 0.9, 0.3), 0.25, 18
ENTRY = """[[effects]]
id = "{}"
axes = [{}]
[effects.parameters]
{}
"""


def arm(folder: Path, dry: Any = DRY, viscous: Any = VISCOUS, more: str = "") -> Path:
    """The example's arm with friction in its file, and a TOML beside it."""
    text = (EXAMPLE / "arm.urdf").read_text()
    for joint, friction, damping in zip(("column", "shoulder", "elbow"), dry, viscous, strict=True):
        head, name, rest = text.partition(f'<joint name="{joint}"')
        end = rest.index("</joint>")
        tag = f'<dynamics damping="{damping}" friction="{friction}"/>'
        text = head + name + rest[:end] + tag + rest[end:]
    (folder / "arm.urdf").write_text(text)
    beside = folder / "arm.toml"
    beside.write_text(f'robot = "arm.urdf"\n{more}')
    return beside


def base_for(file: Path, n: int = 3) -> RobotBase:
    base = base_of(str(file), None, Log.of("run.csv", 0.01, *np.zeros((2, 20, n))))
    assert isinstance(base, RobotBase)
    return base


def listed(base: RobotBase) -> dict[str, list[float]]:
    """First gain of each effect on each axis, 0 where there is none."""
    values = dict[str, list[float]]()
    for use in base.stated.uses:
        own = values.setdefault(use.id, [0.0] * base.n)
        for axis, gain in zip(use.axes, use.gains[0], strict=True):
            own[axis - 1] += gain
    return values

"""Machines with effects for the tests: all of the library at once, any gains zero or not."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from flexhex.fmus.common.effects import Effect, library
from flexhex.fmus.common.machine.effect_use import EffectUse
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.model.effect_bank import Bank
from tests.blocks.loaded import machine
from tests.conftest import MACHINE_FILE

Array = NDArray[np.float64]
BIG = {
    "cross_coupling": {"C": 0.05},
    "time_delay": {"T_delay": 0.0011},
    "drive_lag": {"T_lag": 0.0008},
    "torque_constant_saturation": {"s": 0.02, "tau_k": 0.2},
    "torque_saturation": {"clip": 0.3, "tau_lim": 0.5},
    "offset_drift": {"o_r": 0.07, "T": 2.0},
    "thermal_drift": {"g_t": 0.05, "g_w": 0.01, "T": 2.0},
    "flexible_mode": {"J_2": 0.005},
    "quadratic_drag": {"D_2": 0.3},
    "cubic_stiffness": {"k_3": 100.0},
}
"""Sizes where five times the typical one shows too little or too much within seconds."""
AXES = {"cable_force": 2, "flexible_mode": 3}
"""Axes that turn far or fast enough for it in the tests' short runs."""


def values(effect: Effect) -> dict[str, float]:
    """Parameters of an effect that anybody would notice."""
    sizes = {gain.name: min(5 * gain.typical, gain.high) for gain in effect.gains}
    sizes |= {shape.name: shape.start for shape in effect.shapes if not shape.aside}
    return sizes | BIG.get(effect.id, {})


def axis_of(id: str) -> int:
    """Axis (from 1) on which the tests have an effect, whatever else the library has."""
    return AXES.get(id, crc32(id.encode()) % 6 + 1)


def use(id: str, **other: float) -> EffectUse:
    """An entry with sizes that show."""
    effect = library()[id]
    axes = [] if effect.acts_on == "mechanism" else [axis_of(id)]
    return EffectUse.of(id, axes, **(values(effect) | other))


def with_effects(*uses: EffectUse) -> Machine:
    """The default machine with these effects."""
    return machine().model_copy(update={"effects": uses})


def on_axes() -> list[str]:
    """Ids of all effects but those of the mechanism, whose values are built in."""
    return [id for id, effect in library().items() if effect.acts_on != "mechanism"]


@cache
def everything() -> Machine:
    """All effects that have gains in the plant, each on one axis."""
    return with_effects(*(use(id) for id in on_axes()))


def only(bank: Bank, id: str) -> Array:
    """Gains of a bank, zero but for one effect."""
    mine = [part.effect.id == id for part, _ in bank.gains]
    return np.where(mine, bank.values, 0.0)


def toml(entry: EffectUse) -> str:
    """The entry as a machine file has it."""
    effect = entry.effect
    lines = ["[[effects]]", f'id = "{entry.id}"']
    if entry.axes:
        lines.append(f"axes = {list(entry.axes)}")
    lines.append("[effects.parameters]")
    gains = [(g.name, g.unit, list(row)) for g, row in zip(effect.gains, entry.gains, strict=True)]
    for name, unit, row in gains:
        value: object = row if entry.axes else row[0]
        lines.append(f'{name} = {{ value = {value}, unit = "{unit}", source = "diagnosed" }}')
    for shape, number in zip(effect.shapes, entry.shapes, strict=True):
        if shape.aside:
            continue
        table = f'{{ value = {number!r}, unit = "{shape.unit}", source = "assumed" }}'
        lines.append(f"{shape.name} = {table}")
    return "\n".join([*lines, ""])


def machine_file(folder: Path, *uses: EffectUse) -> Path:
    """The default machine file with these effects, in a folder of its own."""
    path = folder / "subject.toml"
    text = MACHINE_FILE.read_text(encoding="utf-8")
    path.write_text("\n".join([text, *map(toml, uses)]), encoding="utf-8")
    return path

"""Machines of the showcase: truth files drawn from seeds, in the form of machines/tflex-truth.toml.

What is drawn is hidden from everything but the build of machine.fmu and the table's last columns.
"""

from __future__ import annotations

import math
import random
from dataclasses import dataclass
from pathlib import Path

from flexhex.diagnosis.machine_files.toml_text import toml_text
from flexhex.fmus.common.machine_file import read_toml
from flexhex.fmus.machine.truth import KINDS

SEEN_AS = {
    "lugre": ("coulomb_friction", "stribeck_friction"),
    "cubic": ("cubic_stiffness",),
    "cable": ("cable_force",),
    "saturation": ("torque_constant_saturation",),
    "harmonic": ("cogging_harmonic",),
    "drag": ("quadratic_drag",),
    "ripple": ("torque_ripple",),
    "bump": (),
    "inertia": (),
}
"""Effects of the library that a hidden one is rightly named; none: it is outside."""
NEAR = {"lugre": ("second_hysteresis",)}
"""Names that are another form of the same thing: a bristle's law is Dahl's while it is bent."""
INSIDE = tuple(kind for kind, ids in SEEN_AS.items() if ids)
OUTSIDE = tuple(kind for kind, ids in SEEN_AS.items() if not ids)
SMALL, LARGE = 0.006, 0.025
"""Torque of a hidden effect [N m], about 0.6 to 2.5 % of what the axes need."""


@dataclass(frozen=True)
class Hidden:
    """One effect of a truth: kind, axes from 1, its rough size [N m], values by name."""

    kind: str
    axes: tuple[int, ...]
    size: float
    values: dict[str, float]


def drawn(seed: int, number: int, machines: int) -> tuple[Hidden, ...]:
    """What machine `number` (from 1) of a showcase hides; two of all have something outside."""
    apart = random.Random(f"{seed}:outside").sample(range(1, machines + 1), min(2, machines))
    draw = random.Random(f"{seed}:{number}")
    if number in apart:
        return (_one(draw, OUTSIDE[apart.index(number)]),)
    kinds = draw.sample(INSIDE, draw.choice((1, 1, 2, 2, 3)))
    return tuple(_one(draw, kind) for kind in kinds)


def _one(draw: random.Random, kind: str) -> Hidden:
    axes = tuple(sorted(draw.sample(range(1, 7), draw.choice((1, 1, 2, 3, 6)))))
    size = SMALL * (LARGE / SMALL) ** draw.random()
    return Hidden(kind, axes, size, _values(draw, kind, size))


def _values(draw: random.Random, kind: str, s: float) -> dict[str, float]:
    """Values such that an axis that moves by 0.19 rad feels about s [N m] RMS."""
    phase, side = draw.uniform(-math.pi, math.pi), draw.choice((-1.0, 1.0))
    odd = draw.choice([k for k in range(40, 500) if k % 36])
    return {
        "lugre": lambda: {"F_c": s, "F_s": 1.3 * s, "v_s": 0.02, "sigma_0": s / 5e-4},
        "cubic": lambda: {"k": side * s / 0.0026},
        "cable": lambda: {"k": s / 0.05, "begin": side * draw.uniform(0.0, 0.06), "side": side},
        "saturation": lambda: {"level": math.sqrt(8.0 / s)},
        "harmonic": lambda: {"size": 1.41 * s, "order": float(odd), "phase": phase},
        "drag": lambda: {"d": s / 0.1},
        "ripple": lambda: {"size": 0.7 * s, "order": float(odd), "phase": phase},
        "bump": lambda: {
            "height": side * 4 * s,
            "at": draw.uniform(-0.06, 0.06),
            "width": draw.uniform(0.008, 0.02),
        },
        "inertia": lambda: {"size": s / 2, "order": draw.uniform(15.0, 40.0), "phase": phase},
    }[kind]()


def write_machine(base: Path, folder: Path, hidden: tuple[Hidden, ...], seed: int) -> Path:
    """A copy of the machine file `base` with a truth of its own beside it; the copy's path."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "nominal.toml"
    path.write_text(base.read_text(encoding="utf-8"), encoding="utf-8")
    truth = read_toml(base.with_name(f"{base.stem}-truth.toml"))
    truth["seed"] = seed
    truth["cogging"] = {**truth["cogging"], "rms": {**truth["cogging"]["rms"], "value": 0.0}}
    entries = [
        {
            "kind": h.kind,
            "axes": list(h.axes),
            "values": {
                name: {"value": h.values[name], "unit": unit, "source": "assumed"}
                for name, unit in KINDS[h.kind]
            },
        }
        for h in hidden
    ]
    text = toml_text(truth, {"hidden": entries}, [f"drawn, seed {seed}"])
    folder.joinpath("nominal-truth.toml").write_text(text, encoding="utf-8")
    return path

"""The test block in Python: interface, equations, and what the timing rule makes of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import casadi as ca

from flexhex.fmugen.fmu import build_fmu
from flexhex.fmus.common.interface import Interface, Item, Variable

BASE = 0.00025
"""Base step [s]."""
STEP_C = Path(__file__).parent / "toy" / "step.c"
N = 3


def interface(name: str = "toy", period: int = 2, offset: float = 0.5) -> Interface:
    """The test block with a sample time of `period` base steps."""
    variables = (
        Variable("offset", "parameter", "rad", "added to y", start=offset, min=-10, max=10),
        Variable("begin", "parameter", "N m", "first integral", size=N, start=(0.1, 0.2, 0.3)),
        Variable("gain", "parameter", "1", "of u", start=2, min=0, max=9, variability="tunable"),
        Variable("u", "input", "rad", "scaled", min=-1, max=1),
        Variable("a", "input", "N m", "integrated", size=N, min=-5, max=5),
        Variable("y", "output", "rad", "gain u + offset", initial_from=("offset",)),
        Variable("last", "output", "rad", "y one sample ago"),
        Variable("integral", "output", "N m", "of a over time", N, initial_from=("begin",)),
        Variable("ticks", "output", "1", "number of ticks", min=0),
    )
    text, faults = "block for tests of the adapter", (Item("wide", "input u is large"),)
    return Interface(name, text, period * BASE, variables, {"N": N}, faults)


def functions() -> list[ca.Function]:
    """toy_scale(u, gain, offset) -> y and toy_integrate(integral, a, Ts) -> next."""
    u, gain, offset, Ts = (ca.SX.sym(name) for name in ("u", "gain", "offset", "Ts"))
    integral, a = ca.SX.sym("integral", N), ca.SX.sym("a", N)
    return [
        ca.Function("toy_scale", [u, gain, offset], [gain * u + offset], ["u", "g", "o"], ["y"]),
        ca.Function(
            "toy_integrate", [integral, a, Ts], [integral + a * Ts], ["i", "a", "T"], ["n"]
        ),
    ]


def build(out_dir: Path, cache: Path | None = None, **options: object) -> Path:
    """Build the toy FMU; cache: folder of object files; other options as of `interface`."""
    described = interface(**options)  # type: ignore[arg-type]
    return build_fmu(described, functions(), STEP_C, out_dir, cache=cache)


NAMES = tuple(
    name
    for group in (interface().parameters, interface().inputs, interface().outputs)
    for variable in group
    for name in variable.scalar_names
)
VR = {name: reference for reference, name in enumerate(NAMES)}
"""Scalar name -> value reference."""
OUTPUTS = tuple(n for v in interface().outputs for n in v.scalar_names)


@dataclass
class Twin:
    """The timing rule spelt out base step by base step, for the toy with its start values."""

    period: int
    n: int = 0

    def __post_init__(self) -> None:
        self.pending = [0.5, 0.0, 0.1, 0.2, 0.3, 0.0, 0.0]
        self.published = list(self.pending)

    def step(self, count: int, u: float, a: Sequence[float]) -> list[float]:
        """Outputs after `count` base steps with these inputs."""
        for j in range(self.n, self.n + count):
            if j >= 1 and j % self.period == 0:
                y, _, i1, i2, i3, ticks, _ = self.pending
                Ts = self.period * BASE
                integral = [i + k * Ts for i, k in zip((i1, i2, i3), a, strict=True)]
                fault = 2.0 if u > 0.9 else 0.0
                self.pending = [2.0 * u + 0.5, y, *integral, ticks + 1, fault]
            if (j + 1) % self.period == 0:
                self.published = list(self.pending)
        self.n += count
        return list(self.published)

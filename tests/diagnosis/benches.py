"""Candidates on made-up rows: what `diagnosis.rounds` asks of a bench, without any machine."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from types import SimpleNamespace

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.regression import Columns, Regression
from flexhex.diagnosis.rounds import Round
from flexhex.diagnosis.scales import Scales
from flexhex.fmus.common.effects import Shape
from tests.diagnosis.rowsets import layout, regression, signals
from tests.diagnosis.usual import usual

Array = NDArray[np.float64]
N = 2
ROWS = layout(N)
NAMES = ("one", "two", "three", "four", "five", "six", "seven", "eight")


@dataclass
class Made:
    """Stands for `flexhex.diagnosis.calibrate.Calibrated`: unit noise, torque of RMS ten."""

    regression: Regression
    between: bool = True
    noise: SimpleNamespace = field(
        default_factory=lambda: SimpleNamespace(scale=np.ones(N), floor=np.ones(N))
    )
    base: SimpleNamespace = field(default_factory=lambda: SimpleNamespace(n=N))
    torque_rms: Array = field(default_factory=lambda: np.full(N, 10.0))
    layout = ROWS
    known: tuple[()] = ()
    kept: tuple[slice] = (slice(None),)

    @property
    def B(self) -> list[Array]:
        return [np.zeros((len(ROWS.axis) // N, N, 0))]


@dataclass
class Bench:
    """Stands for `flexhex.diagnosis.candidates.Bench`: one shape and one column for each effect."""

    made: Made
    drawn: dict[str, Array]
    low: float = -np.inf
    across: bool = False
    n: int = N
    whole: list[str] = field(default_factory=list)
    freer: tuple[str, ...] = ()
    confused: tuple[str, ...] = ()
    exact: bool = False

    @property
    def effects(self) -> dict[str, SimpleNamespace]:
        gains = [SimpleNamespace(low=self.low, high=np.inf, unit="1")]
        common = {"confused_with": self.confused, "extends": "", "exact": self.exact}
        effect = SimpleNamespace(gains=gains, **common)
        item = SimpleNamespace(effect=effect, shapes=[{}], searched=[], freedom=1)
        freer = SimpleNamespace(**{**vars(item), "freedom": 2, "shapes": [{}, {}]})
        return {name: freer if name in self.freer else item for name in self.drawn}

    @property
    def scales(self) -> Scales:
        return usual(self.effects)

    def searched(self, name: str, axis: int) -> list[Shape]:
        return []

    def names(self, axis: int | None) -> list[str]:
        return list(self.drawn) if axis is not None else []

    def thin(self, name: str, axis: int, shape: dict[str, float]) -> list[Array]:
        return [self.drawn[name][ROWS.rows(axis)]]

    def grid(self, name: str, axis: int) -> list[tuple[dict[str, float], Columns]]:
        return [({}, Columns(axis, self.drawn[name][ROWS.rows(axis)]))]


def bench(sizes: dict[tuple[str, int], float], drawn: dict[str, Array] | None = None) -> Bench:
    """Rows with effects (name, axis) of given sizes hidden, beside candidates that are not."""
    drawn = drawn or {name: signals(ROWS, 1, 20 + k) for k, name in enumerate(NAMES)}
    base = regression(ROWS)
    y = base.y.copy()
    for (name, axis), size in sizes.items():
        y[ROWS.rows(axis)] += size * drawn[name][ROWS.rows(axis), 0]
    return Bench(Made(replace(base, y=y)), drawn)


def chosen(rounds: list[Round]) -> list[tuple[str, tuple[int, ...]]]:
    return [(r.chosen.id, r.chosen.axes) for r in rounds if r.chosen]

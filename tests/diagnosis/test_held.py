"""Gains that cannot be negative: what would have to be is held at zero, and the rest is asked."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np

from flexhex.diagnosis.answer import joint
from flexhex.diagnosis.regression import Columns
from flexhex.diagnosis.rounds import search
from tests.diagnosis.benches import ROWS, Array, Bench, bench
from tests.diagnosis.rowsets import signals


@dataclass
class Warming(Bench):
    """One effect with two gains, neither of them negative, of one shape or the other."""

    extends: str = ""

    @property
    def effects(self) -> dict[str, SimpleNamespace]:
        gains = [SimpleNamespace(low=0.0, high=np.inf, unit="1")] * 2
        common = {"confused_with": (), "extends": self.extends, "exact": False}
        effect = SimpleNamespace(gains=gains, shapes=[], **common)
        item = SimpleNamespace(effect=effect, shapes=[{}, {}], searched=[], freedom=2)
        return {"warm": item}

    def grid(self, name: str, axis: int) -> list[tuple[dict[str, float], Columns]]:
        return [({"T": T}, self.columns(name, axis, {"T": T})) for T in (1.0, 2.0)]

    def columns(self, name: str, axis: int, shape: dict[str, float]) -> Columns:
        part = slice(0, 2) if shape["T"] == 1.0 else slice(2, 4)
        return Columns(axis, self.drawn[name][ROWS.rows(axis), part])


def warming(extends: str = "") -> tuple[Warming, Array]:
    """0.6 of a cause is there; the first shape has it as a difference of two columns, the second
    has a column that is nearly the cause beside one that has nothing to do with it."""
    cause, other, third = (signals(ROWS, 1, seed) for seed in (20, 21, 22))
    near = 0.95 * cause + 0.3 * third
    columns = np.hstack([other, cause + 0.7 * other, signals(ROWS, 1, 23), near])
    made = bench({("cause", 0): 0.6}, {"cause": cause}).made
    return Warming(made, {"warm": columns}, extends=extends), cause


def test_gain_that_would_be_negative_is_held_at_zero_with_the_best_shape_for_the_rest() -> None:
    made, _ = warming()
    found = search(made)[0].chosen
    assert found is not None
    (part,) = found.parts
    assert (part.still, part.shape) == ((0,), {"T": 2.0})
    assert part.gain.beta[0] == 0.0
    # 0.95 of the cause is in a column whose square is 0.95^2 + 0.3^2
    assert abs(part.gain.beta[1] - 0.6 * 0.95 / (0.95**2 + 0.3**2)) < 0.1
    held = joint(made, [found])
    ((zero, beta),) = held.beta
    assert zero == 0.0
    assert beta > 0.4
    (deviation,) = held.deviation
    assert deviation[0] == 0.0
    assert 0 < deviation[1] < 0.1


def test_effect_that_extends_another_is_not_held_at_that_one() -> None:
    made, _ = warming(extends="something simpler")
    assert search(made)[0].chosen is None

"""States of effects along the runs: each from rest, or on from run to run where time does;
errors of angles, which are kept."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.hypotheses.candidates import Bench

Array = NDArray[np.float64]
TS, COUNT = 0.5, 4


def states(starts: list[float], across: bool) -> list[list[float]]:
    """Of an effect that counts its samples, along runs of four samples, 2 s each."""
    run = lambda start: SimpleNamespace(start=start, motion=SimpleNamespace(ts=TS))  # noqa: E731
    blocks = [SimpleNamespace(run=run(start)) for start in starts]
    model: Any = SimpleNamespace(base=SimpleNamespace(n=1), blocks=blocks)
    bench = Bench(model, [], across)
    bench._inputs = lambda axis, alone: [np.zeros((COUNT, 6)) for _ in blocks]  # type: ignore[method-assign]

    def along(state: Array, inputs: Array, fixed: Array) -> Array:
        return state + np.arange(1.0, len(inputs) + 1)[:, None]

    effect = SimpleNamespace(start=lambda theta, shape: [10.0], entered=False, geared=False)
    item: Any = SimpleNamespace(along=along, effect=effect, by_way=False, alone=True)
    return [z[:, 0].tolist() for z in bench._states(item, {}, 0, np.zeros(1))]


def test_every_run_begins_at_rest() -> None:
    assert states([0.0, 2.0], across=False) == 2 * [[11.0, 12.0, 13.0, 14.0]]


def test_state_goes_on_where_the_run_before_ended() -> None:
    assert states([0.0, 2.0], across=True) == [[11.0, 12.0, 13.0, 14.0], [15.0, 16.0, 17.0, 18.0]]


def test_order_is_that_of_time() -> None:
    assert states([2.0, 0.0], across=True) == [[15.0, 16.0, 17.0, 18.0], [11.0, 12.0, 13.0, 14.0]]


@pytest.mark.parametrize("starts", [[4.0], [0.0, 4.0]])
def test_what_was_before_a_run_and_is_not_known_was_like_it(starts: list[float]) -> None:
    """The last run begins after 4 s: eight samples were before it, known or not."""
    assert states(starts, across=True)[-1] == [19.0, 20.0, 21.0, 22.0]


def test_angle_error_is_kept_for_its_shape_alone() -> None:
    calls: list[tuple[int, float]] = []

    def columns(inputs: Array, state: Array, fixed: Array) -> list[Array]:
        return [fixed.copy()]

    shape = SimpleNamespace(name="s")
    effect = SimpleNamespace(id="error", acts_on="measurement", shapes=[shape], geared=False)
    item: Any = SimpleNamespace(effect=effect, columns=columns)
    bench: Any = Bench(SimpleNamespace(base=SimpleNamespace(n=1)), [item])  # type: ignore[arg-type]
    bench._inputs = lambda item, axis: [np.zeros((COUNT, 6))]

    def turned(k: int, axis: int, error: Array) -> Array:
        calls.append((axis, error[0, 0]))
        return error

    bench._misread = SimpleNamespace(turned=turned)
    requests = [(0, 1.0), (0, 1.0), (1, 1.0), (0, 2.0), (0, 2.0), (1, 1.0)]
    for axis, value in requests:
        (thinned,) = bench.thin("error", axis, {"s": value})
        assert (thinned == value).all()
    assert calls == [(0, 1.0), (1, 1.0), (0, 2.0)]
    bench.forget()
    bench.thin("error", 0, {"s": 2.0})
    assert calls[3:] == [(0, 2.0)]

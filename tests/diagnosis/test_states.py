"""States of effects along the runs: each as it begins, or on from run to run where time does;
errors of angles, which are kept."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.hypotheses.candidates import Bench
from flexhex.diagnosis.hypotheses.compiled import ACCELERATION
from flexhex.diagnosis.hypotheses.turning import states_of

Array = NDArray[np.float64]
TS, COUNT, WINDOW = 0.5, 4, 1.0


def states(
    starts: list[float], across: bool, accelerations: Array | None = None
) -> list[list[float]]:
    """Of an effect that counts its samples from 10 and the first acceleration, along runs of four
    samples, 2 s each."""
    runs: Any = [SimpleNamespace(start=start, motion=SimpleNamespace(ts=TS)) for start in starts]

    def along(state: Array, inputs: Array, fixed: Array) -> Array:
        return state + np.arange(1.0, len(inputs) + 1)[:, None]

    def start(first: Array, fixed: Array) -> list[Array]:
        return [10.0 + first[:, [ACCELERATION]]]

    effect = SimpleNamespace(shapes=())
    item: Any = SimpleNamespace(along=along, start=start, effect=effect, by_way=False)
    moved = np.zeros((COUNT, 6))
    if accelerations is not None:
        moved[:, ACCELERATION] = accelerations
    listed = states_of(item, {}, 0, runs, [(moved, moved) for _ in runs], across, WINDOW)
    return [z[:, 0].tolist() for z in listed]


def test_every_run_begins_anew() -> None:
    assert states([0.0, 2.0], across=False) == 2 * [[11.0, 12.0, 13.0, 14.0]]


def test_run_begins_as_it_moves_over_the_window_in_which_an_acceleration_is_known() -> None:
    (found,) = states([0.0], False, np.array([3.0, 5.0, 100.0, 100.0]))
    assert found == [15.0, 16.0, 17.0, 18.0]


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

    effect = SimpleNamespace(id="error", acts_on="measurement", geared=False)
    item: Any = SimpleNamespace(effect=effect)
    bench: Any = Bench(SimpleNamespace(base=SimpleNamespace(n=1)), [item])  # type: ignore[arg-type]
    bench.along = SimpleNamespace(
        columns=lambda item, axis, shape: [np.full((COUNT, 1), shape["s"])],
        forget=lambda: None,
    )

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

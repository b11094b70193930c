"""Missing rates and accelerations: smooth across rows, exact on polynomials, at rest at ends."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.interpolate import BPoly

from flexhex.trajectory.smooth import completed
from tests.compare import assert_close

Array = NDArray[np.float64]
TIME = np.array([0.0, 0.2, 0.3, 0.7, 1.0, 1.1, 1.6, 2.0])
SPAN = TIME[-1]


def rest_to_rest(time: Array) -> list[Array]:
    """Values, rates, accelerations (rows, 2) of one quintic from rest to rest, and of twice it."""
    p = np.poly1d([6, -15, 10, 0, 0, 0])
    parts = [p.deriv(k)(time / SPAN) / SPAN**k for k in range(3)]
    return [np.column_stack([part, 2 * part]) for part in parts]


@pytest.mark.parametrize("given", [2, 3])
def test_a_quintic_from_rest_to_rest_is_reproduced(given: int) -> None:
    """It is the smoothest motion through its own points and rates."""
    expected = rest_to_rest(TIME)
    result = completed(TIME, expected[:given])
    for part, wanted in zip(result, expected, strict=True):
        # rounding over steps of 0.1 s, squared
        assert_close(part, wanted, atol=1e-12)


@pytest.mark.parametrize(("given", "smooth"), [(1, 2), (2, 3)])
def test_pieces_join_without_a_step(given: int, smooth: int) -> None:
    """All derivatives up to `smooth`, at every row inside, of random motions."""
    rng = np.random.default_rng(6)
    parts = [rng.normal(size=(len(TIME), 3)) for _ in range(given)]
    for part in parts[1:]:
        part[[0, -1]] = 0.0
    result = completed(TIME, parts)
    for part, wanted in zip(result, parts, strict=False):
        assert np.array_equal(part, wanted)
    for part in result[1:]:
        assert_close(part[[0, -1]], np.zeros((2, 3)), atol=1e-9)
    played = BPoly.from_derivatives(TIME, np.stack(result, axis=1))
    for order in range(smooth + 1):
        piece = played.derivative(order) if order else played
        near = 1e-12
        before, after = piece(TIME[1:-1] - near), piece(TIME[1:-1] + near)
        size = np.abs(piece(np.linspace(0, SPAN, 500))).max()
        assert_close(before, after, atol=1e-8 * size, what=f"derivative {order}")
    next_one = played.derivative(smooth + 1)
    step = next_one(TIME[1:-1] + 1e-12) - next_one(TIME[1:-1] - 1e-12)
    assert np.abs(step).max() > 1, "random motions have a step in the next derivative"


def test_rates_of_values_alone_converge_with_the_spacing() -> None:
    """A spline of third degree: rates as the cube of the spacing, accelerations as its square."""
    worst = []
    for rows in (21, 41):
        time = np.linspace(0, SPAN, rows)
        expected = rest_to_rest(time)
        result = completed(time, expected[:1])
        worst.append([np.abs(f - e).max() for f, e in zip(result, expected, strict=True)])
    assert worst[0][0] == 0
    assert worst[0][1] / worst[1][1] > 7
    assert worst[0][2] / worst[1][2] > 3.5


def test_two_rows_are_the_smoothest_move() -> None:
    time = np.array([0.0, SPAN])
    expected = rest_to_rest(time)
    for actual, wanted in zip(completed(time, expected[:1]), expected, strict=True):
        assert_close(actual, wanted, atol=1e-12)
    for actual, wanted in zip(completed(time, expected[:2]), expected, strict=True):
        assert_close(actual, wanted, atol=1e-12)

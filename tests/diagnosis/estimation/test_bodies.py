"""Values that a machine can have: the nearest ones, and never others."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Known
from flexhex.diagnosis.estimation.bodies import (
    GAP,
    TEN,
    Body,
    bodies_of,
    consistent,
    possible,
    pseudo_inertia,
    ten_of,
)
from tests.compare import assert_close

Array = NDArray[np.float64]
BODY = Body("link", tuple(range(10)))


def points(masses: Array, places: Array) -> Array:
    """The ten parameters of point masses (k,) at places (k, 3), by their definition."""
    J = sum(m * (r @ r * np.eye(3) - np.outer(r, r)) for m, r in zip(masses, places, strict=True))
    assert isinstance(J, np.ndarray)
    six = J[0, 0], J[0, 1], J[1, 1], J[0, 2], J[1, 2], J[2, 2]
    return np.array([masses.sum(), *(masses @ places), *six])


def drawn(rng: np.random.Generator, size: float = 0.2) -> Array:
    """A body of eight point masses."""
    return points(rng.uniform(0.1, 1.0, 8), size * rng.standard_normal((8, 3)))


def test_pseudo_inertia_is_the_second_moment_of_mass() -> None:
    rng = np.random.default_rng(0)
    masses, places = rng.uniform(0.1, 1.0, 8), rng.standard_normal((8, 3))
    whole = np.column_stack([places, np.ones(8)])
    ten = points(masses, places)
    assert_close(pseudo_inertia(ten), whole.T * masses @ whole, atol=1e-12)
    assert_close(ten_of(pseudo_inertia(ten)), ten, atol=1e-12)


IMPOSSIBLE = {
    "mass": (0, -1.0),
    "first moment": (1, 5.0),
    "moment of inertia": (4, -0.1),
    "triangle inequality": (9, 10.0),
    "product of inertia": (5, 3.0),
}


@pytest.mark.parametrize("name", IMPOSSIBLE)
def test_bodies_that_cannot_be_are_seen(name: str) -> None:
    ten = drawn(np.random.default_rng(1))
    assert consistent(ten)
    place, value = IMPOSSIBLE[name]
    ten[place] = value
    assert not consistent(ten)


def tight(rng: np.random.Generator, count: int) -> Array:
    """A curvature (count, count) with eigenvalues over four decades, far above `GAP`."""
    q, _ = np.linalg.qr(rng.standard_normal((count, count)))
    return np.asarray(q * np.geomspace(1e2, 1e6, count) @ q.T)


@pytest.mark.parametrize("seed", range(6))
def test_nearest_values_are_nearest_of_all_that_can_be(seed: int) -> None:
    rng = np.random.default_rng(seed)
    file, H = drawn(rng), tight(rng, 12)
    wanted = np.append(file + 0.3 * rng.standard_normal(10), (-0.2, 0.4))
    result = possible(wanted, H, [(BODY, file)], [10])
    assert consistent(result.values[:10])
    assert result.values[10] > 0
    # of a convex problem: no way to any other body goes downhill
    slope = H @ (result.values - wanted)
    for _ in range(300):
        other = np.append(drawn(rng, rng.uniform(0.01, 1.0)), rng.uniform(0, 1, 2))
        other[:10] *= np.exp(rng.uniform(-4, 2))
        assert slope @ (other - result.values) > -GAP
    assert_close(result.excess, slope @ (result.values - wanted), rtol=1e-9)


def test_fixed_values_stay_where_they_are() -> None:
    rng = np.random.default_rng(7)
    file = points(np.ones(6), 0.1 * np.vstack([np.eye(3), -np.eye(3)]))
    H = tight(rng, 10)
    H[1], H[:, 1] = 0.0, 0.0
    wanted = file + np.array([0, 0, 2.0, 0, 0, 0, 0, 0, 0, 0])
    result = possible(wanted, H, [(BODY, file)], [])
    assert consistent(result.values)
    assert result.values[1] == file[1]


def test_values_that_can_be_stay_as_they_are() -> None:
    rng = np.random.default_rng(3)
    ten = drawn(rng)
    result = possible(ten, tight(rng, 10), [(BODY, drawn(rng))], [])
    assert result.excess == 0
    assert_close(result.values, ten, atol=0.0)


def test_a_file_that_describes_no_body_is_no_start() -> None:
    rng = np.random.default_rng(5)
    file = drawn(rng)
    file[9] = 10.0
    result = possible(file, tight(rng, 10), [(BODY, file)], [])
    assert consistent(result.values)


def test_bodies_are_those_with_all_ten_parameters() -> None:
    names = [*(f"a.{name}" for name in TEN), "b.m", "b.mc_x", "J_r[1]", "payload 0.8 kg.m"]
    known = [Known(name, "", 0.0, 1.0, "") for name in names]
    assert bodies_of(known) == [Body("a", tuple(range(10)))]

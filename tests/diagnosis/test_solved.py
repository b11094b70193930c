"""A fit whose products between passes noise has made negative."""

from __future__ import annotations

import numpy as np
import pytest

from flexhex.diagnosis.selection.solved import factor_of


@pytest.mark.parametrize("chance", [-0.2, -0.99, -1.0, -1.01, -3.0])
def test_parameter_that_shows_in_no_pass_keeps_its_tolerance(chance: float) -> None:
    """Its product with itself is at its smallest nothing, whatever chance says of it."""
    G, prior = np.array([[4.0, 0.1], [0.1, chance]]), np.array([0.0, 1.0])
    factor = factor_of(G, prior)
    q = factor.solve(np.array([2.0, -0.14]))
    assert q[0] == pytest.approx(0.5, abs=0.01)
    assert abs(q[1]) < 0.3
    assert factor.sure == (chance > -1.0)

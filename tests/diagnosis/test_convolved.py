"""Long convolutions against sums."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from flexhex.numeric.convolved import convolved


@pytest.mark.parametrize(("samples", "taps"), [(50, 1), (51, 8), (40, 40), (101, 24)])
def test_convolved_is_the_sum_under_all_weights(samples: int, taps: int) -> None:
    """Rounding of some hundred terms of about one."""
    rng = np.random.default_rng(samples)
    values, weights = rng.standard_normal((samples, 2)), rng.standard_normal(taps)
    sums = np.stack([np.convolve(v, weights, "valid") for v in values.T], axis=1)
    assert_allclose(convolved(values, weights), sums, atol=1e-12)
    assert_allclose(convolved(values[:, 0], weights), sums[:, 0], atol=1e-12)

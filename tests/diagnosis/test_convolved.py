"""Convolution by Fourier transforms against sums, power densities against SciPy's."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.signal import welch

from flexhex.diagnosis.result.maps import SEGMENT, density
from flexhex.numeric.convolved import convolved


@pytest.mark.parametrize(("samples", "taps"), [(50, 1), (51, 8), (40, 40), (101, 24)])
def test_convolved_is_the_sum_under_all_weights(samples: int, taps: int) -> None:
    """Rounding of some hundred terms of about one."""
    rng = np.random.default_rng(samples)
    values, weights = rng.standard_normal((samples, 2)), rng.standard_normal(taps)
    sums = np.stack([np.convolve(v, weights, "valid") for v in values.T], axis=1)
    assert_allclose(convolved(values, weights), sums, atol=1e-12)
    assert_allclose(convolved(values[:, 0], weights), sums[:, 0], atol=1e-12)


def test_density_is_that_of_welch() -> None:
    """With an end that fills no segment, and beside a mean that is no part of it."""
    values = 3.0 + np.random.default_rng(1).standard_normal(5 * SEGMENT + 17)
    _, theirs = welch(values, 200.0, nperseg=SEGMENT)
    assert_allclose(density(values, 0.005), theirs, rtol=1e-10)

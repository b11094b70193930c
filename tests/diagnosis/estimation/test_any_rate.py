"""Parameters of an axis from logs at 60 Hz and at 20 kHz, by a motion of NumPy."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.estimation.identified import identify
from flexhex.diagnosis.prepare import Options

Array = NDArray[np.float64]
TRUE = {"J[1]": 0.08, "d[1]": 0.3, "F_c[1]": 0.12}


def written(path: Path, t: Array, seed: int, fastest: float) -> Path:
    """Sums of sines up to `fastest` [rad/s], with friction that turns over with the rate."""
    rng = np.random.default_rng(seed)
    w, phase = rng.uniform(1.0, fastest, 5), rng.uniform(0, 2 * np.pi, 5)
    x = np.outer(t, w) + phase
    v, a = 0.5 * np.cos(x).sum(axis=1), -(0.5 * w * np.sin(x)).sum(axis=1)
    tau = TRUE["J[1]"] * a + TRUE["d[1]"] * v + TRUE["F_c[1]"] * np.tanh(v / 0.005)
    rows = np.column_stack([t, (0.5 / w * np.sin(x)).sum(axis=1), tau])
    rows[:, 1:] += rng.standard_normal((len(t), 2)) * (1e-6, 0.005)
    head = "time,theta,tau_meas\ns,rad,N m"
    np.savetxt(path, rows, delimiter=",", header=head, comments="", fmt="%.10g")
    return path


@pytest.mark.parametrize(("rate", "seconds", "fastest", "within"), [
    (60.0, 40.0, 5.0, 0.01),
    (20e3, 6.0, 14.0, 0.005),
])  # fmt: skip
def test_parameters_are_right_at_any_rate(
    rate: float, seconds: float, fastest: float, within: float, tmp_path: Path
) -> None:
    t = np.arange(round(seconds * rate)) / rate
    paths = [written(tmp_path / f"{seed}.csv", t, seed, fastest) for seed in (1, 2)]
    identified = identify(paths, options=Options("axis"))
    for name, true in TRUE.items():
        estimate = identified[name].estimate
        # a reversal of friction lies between two samples of 60 Hz: hence not the interval alone
        assert estimate.value == pytest.approx(true, rel=within), name
        low, high = estimate.ci95
        assert high - low < 4 * within * true, name

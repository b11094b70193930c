"""A delay of the torques is looked for anew beside the effects that were found."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.hypotheses.candidates import Bench
from flexhex.diagnosis.jointfit.answer import Joint, joint
from flexhex.diagnosis.jointfit.beside import beside
from flexhex.diagnosis.jointfit.fit import calibrate, held
from flexhex.diagnosis.prepare import Options, run_set_of
from flexhex.diagnosis.runs.blocks import blocks
from flexhex.diagnosis.runs.span import spacing_for
from tests.diagnosis import two_links
from tests.diagnosis.synthetic import plain_csv
from tests.diagnosis.test_payloads_arm import planar

Array = NDArray[np.float64]
__all__ = ["planar"]
LATE, PACES = 2, (20.0, 60.0)
"""Samples by which all torques are late; range of the motions' frequencies [rad/s]: within some
samples they turn so far that a tangent leads astray."""


def moved(t: Array, seed: int) -> tuple[Array, Array, Array]:
    """theta, thetad, thetadd (samples, 2)."""
    rng = np.random.default_rng(seed)
    w, phase = rng.uniform(*PACES, (6, 2)), rng.uniform(0, 2 * np.pi, (6, 2))
    x = w * t[:, None, None] + phase
    waves = np.sin(x), w * np.cos(x), -(w**2) * np.sin(x)
    theta, rate, acceleration = ((0.4 / w * wave).sum(axis=1) for wave in waves)
    return theta, rate, acceleration


@pytest.fixture
def fit(planar: str, tmp_path: Path) -> Joint:
    """An arm's base model beside no effects."""
    t, paths = np.arange(round(two_links.SECONDS / two_links.TS)) * two_links.TS, []
    for motion, number in ((1, 1), (1, 2), (2, 1), (2, 2)):
        rng = np.random.default_rng([motion, number])
        theta = moved(t, motion)[0] + 2e-6 * rng.standard_normal((len(t), 2))
        tau = two_links.torque(moved(t - LATE * two_links.TS, motion), 0.0, (0.0, 0.0))
        tau += two_links.NOISE * rng.standard_normal(tau.shape)
        head = {"trajectory": str(motion), "pass": str(number)}
        log = {"time": t, "theta": theta, "tau_meas": tau}
        paths.append(plain_csv(tmp_path / f"{motion}{number}.csv", log, **head))
    base, run_set, _ = run_set_of(paths, [], None, Options(base=planar))
    spacing = spacing_for(base, run_set.runs)
    return joint(Bench(calibrate(base, blocks(base, run_set.runs, spacing)), []), [])


@pytest.mark.parametrize("samples", [-4, -2, 7, 9])
def test_delay_does_not_depend_on_where_it_was(samples: int, fit: Joint) -> None:
    bench = Bench(held(fit.bench.model, samples * two_links.TS), [])
    delay = beside(joint(bench, [])).fitted.delay
    assert delay == pytest.approx(LATE * two_links.TS, abs=0.02 * two_links.TS)

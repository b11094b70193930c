"""A delay of the torques is that of the axes on which nothing is missing."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.hypotheses.candidates import Bench
from flexhex.diagnosis.jointfit.answer import Joint, joint
from flexhex.diagnosis.jointfit.fit import calibrate
from flexhex.diagnosis.jointfit.guard import delay_of, without_bent_delay
from flexhex.diagnosis.prepare import Options, run_set_of
from flexhex.diagnosis.runs.blocks import blocks
from flexhex.diagnosis.runs.span import spacing_for
from tests.diagnosis import two_links
from tests.diagnosis.synthetic import plain_csv
from tests.diagnosis.test_payloads_arm import planar

Array = NDArray[np.float64]
__all__ = ["planar"]
LATE, MORE = 2, 4
"""Samples by which all torques are late; by how many more a part of one seems to be."""


def fit_of(folder: Path, base: str, fading: float) -> Joint:
    """An arm whose torques are all `LATE`; on axis 1 something is missing that begins like a delay
    and is gone after some seconds."""
    paths = []
    for motion, number in ((1, 1), (1, 2), (2, 1), (2, 2)):
        run = two_links.run(motion, number, 0.0, (0.0, 0.0))
        tau = np.roll(run["tau_meas"], LATE, axis=0)
        smooth = np.roll(
            two_links.torque(two_links.moved(run["time"], motion), 0.0, (0.0, 0.0)), LATE, axis=0
        )
        tau[:, 0] -= fading * MORE * np.gradient(smooth[:, 0]) * np.exp(-run["time"] / 2)
        cut = {name: values[20:-20] for name, values in {**run, "tau_meas": tau}.items()}
        head = {"trajectory": str(motion), "pass": str(number)}
        paths.append(plain_csv(folder / f"{motion}{number}.csv", cut, **head))
    base_model, run_set, _ = run_set_of(paths, [], None, Options(base=base))
    spacing = spacing_for(base_model, run_set.runs)
    return joint(Bench(calibrate(base_model, blocks(base_model, run_set.runs, spacing)), []), [])


def test_what_is_missing_on_one_axis_does_not_bend_the_delay_of_all(
    planar: str, tmp_path: Path
) -> None:
    fit = fit_of(tmp_path, planar, 1.0)
    bent, deviation = delay_of(fit)
    assert bent > LATE * two_links.TS + 4 * deviation
    held = without_bent_delay(fit, 4.0, 0.004)
    assert held is not None
    assert abs(held.fitted.expected - LATE * two_links.TS) < 0.25 * two_links.TS
    again = joint(Bench(held, []), [])
    assert delay_of(again)[0] == pytest.approx(held.fitted.expected, abs=2e-5)


def test_delay_of_all_axes_stands(planar: str, tmp_path: Path) -> None:
    assert without_bent_delay(fit_of(tmp_path, planar, 0.0), 4.0, 0.004) is None

"""Friction of a joint of an arm that grows with the rate: more than an error of one friction."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexhex.diagnosis.workflow import Options, diagnose
from tests.diagnosis import two_links
from tests.diagnosis.synthetic import plain_csv
from tests.diagnosis.test_payloads_arm import planar

__all__ = ["planar"]

COULOMB, VISCOUS, PEAK, RATE = 0.6, 0.9, 0.4, 0.1
"""Friction torque [N m], viscous friction [N m s/rad], what is added at rest [N m] and the rate at
which that is 1/e [rad/s]."""


@pytest.mark.parametrize("peak", [0.0, PEAK])
def test_what_grows_with_the_rate_is_no_error_of_form(
    planar: str, tmp_path: Path, peak: float
) -> None:
    """Rows that repeat to 0.2 % of the torque outweigh any guess of how exact a form is."""
    paths = []
    for motion in (1, 2, 3):
        for number in (1, 2):
            run = two_links.run(motion, number, 0.0, (0.0, 0.0))
            rate = two_links.moved(run["time"], motion)[1][:, 1]
            dry = COULOMB + peak * np.exp(-((rate / RATE) ** 2))
            run["tau_meas"][:, 1] += dry * np.tanh(rate / 2e-3) + VISCOUS * rate
            head = {"trajectory": str(motion), "pass": str(number)}
            paths.append(plain_csv(tmp_path / f"{motion}{number}.csv", run, **head))
    viscous, dry = sorted(
        diagnose(paths, options=Options(base=planar)).effects,
        key=lambda effect: "F_c" in effect.parameters,
    )
    assert (viscous.id, viscous.axes) == ("viscous_friction", (2,))
    assert ("stribeck_friction" if peak else "coulomb_friction") in (dry.id, *dry.rivals)
    assert viscous.parameters["d_v"].value == pytest.approx(VISCOUS, rel=0.1)
    assert dry.parameters["F_c"].value == pytest.approx(COULOMB, rel=0.15)

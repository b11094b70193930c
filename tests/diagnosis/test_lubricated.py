"""Dry friction that turns over within a rate, as of a lubricated contact, is no delay."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexhex.diagnosis.workflow import Options, diagnose
from tests.diagnosis import two_links
from tests.diagnosis.synthetic import plain_csv
from tests.diagnosis.test_payloads_arm import planar

__all__ = ["planar"]
COULOMB = 0.6
"""Friction torque [N m]."""


@pytest.mark.parametrize(("within", "viscous"), [(0.03, 0.0), (0.03, 0.25), (0.05, 0.15)])
def test_friction_that_turns_over_within_a_rate_leaves_nothing(
    planar: str, tmp_path: Path, within: float, viscous: float
) -> None:
    """Nor does it stand for viscous friction beside it, which a wider rate would imitate."""
    paths = []
    for motion in (1, 2, 3):
        for number in (1, 2):
            run = two_links.run(motion, number, 0.0, (0.0, 0.0))
            rate = two_links.moved(run["time"], motion)[1]
            run["tau_meas"] += COULOMB * np.tanh(rate / within) + viscous * rate
            head = {"trajectory": str(motion), "pass": str(number)}
            paths.append(plain_csv(tmp_path / f"{motion}{number}.csv", run, **head))
    found = diagnose(paths, options=Options(base=planar))
    dry, *others = sorted(found.effects, key=lambda effect: effect.id)
    assert (dry.id, dry.axes) == ("coulomb_friction", (1, 2))
    assert [(o.id, o.axes) for o in others] == ([("viscous_friction", (1, 2))] if viscous else [])
    for axis in (1, 2):
        assert dry.parameters[f"F_c[{axis}]"].value == pytest.approx(COULOMB, rel=0.03)
        low, high = dry.parameters[f"v_0[{axis}]"].ci95
        assert low < within < high
    for value in (v for other in others for v in other.parameters.values()):
        assert value.value == pytest.approx(viscous, rel=0.03)
    assert not any("delay" in text for text in found.findings)
    assert (found.residual.repeatable_after < 0.012 * COULOMB).all()

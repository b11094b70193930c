"""A diagnosis beside a base model that came out as no machine is doubts that model."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexhex.diagnosis.kinds import LINEAR, ROTARY
from flexhex.diagnosis.prepare import Options
from flexhex.diagnosis.result.negative import Asked, below_zero
from flexhex.diagnosis.workflow import diagnose
from tests.diagnosis.estimation import machines

RATES = np.array([-2.0, 1.0, 2.0])


def runs(folder: Path, sign: float) -> list[Path]:
    """An axis with friction, two passes of two motions; sign: of its reported torque."""
    t, paths = np.arange(4000) * machines.TS, []
    for seed in (1, 2):
        q, v, a = machines.moved(t, seed, (0.8,))
        tau = sign * (0.4 * a + machines.rubbed(v, (0.2,), (0.3,)))
        for again in (1, 2):
            path, head = folder / f"{seed}-{again}.csv", f"# trajectory: {seed}\n"
            rows = path, t, q, tau, (False,), head, 10 * seed + again
            paths.append(machines.write(*rows))
    return paths


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_turned_sign_is_doubted_before_what_is_named(sign: float, tmp_path: Path) -> None:
    diagnosis = diagnose(runs(tmp_path, sign), options=Options("axis"))
    said = diagnosis.doubt.startswith("axis 1 comes out with J[1] = -0.4")
    assert said == (sign < 0)
    assert not diagnosis.doubt or diagnosis.findings[0] == diagnosis.doubt
    assert (diagnosis.confidence is None) == (sign < 0)


@pytest.mark.parametrize(("values", "said"), [
    ({"J": 0.4, "d": 0.3, "F_c": 0.2}, ""),
    ({"d": -0.01, "F_c": 0.2}, ""),
    ({"J": -0.4, "d": 0.3, "F_c": 0.2}, "are of other times, something elastic swings"),
    ({"J": -0.4, "d": -0.3, "F_c": 0.2}, "has the other sign"),
    ({"d": -0.3, "F_c": 0.2}, "has the other sign"),
    ({"d": -0.1, "F_c": 0.9}, "friction falls with the rate"),
    ({"d": 0.9, "F_c": -0.1}, "friction grows faster than the rate"),
])  # fmt: skip
def test_reason_is_that_of_what_is_below_zero(values: dict[str, float], said: str) -> None:
    """4 deviations of 0.01; at rates of 2 rad/s friction takes 3 d + 1.7 F_c of power."""
    own = [Asked(f"{name}[2]", value, 0.01, "u") for name, value in values.items()]
    text = below_zero(1, ROTARY, own, RATES, 4.0)
    assert (said in text) if said else text == ""
    if said:
        assert text.startswith("axis 2 comes out with ")
        assert f"d[2] = {values['d']:.3g} ± 0.02 u" in text


def test_sliding_axes_have_forces_and_positions() -> None:
    own = [Asked("m[1]", -3.0, 0.1, "kg")]
    assert "its force or its position has the other sign" in below_zero(0, LINEAR, own, RATES, 4.0)

"""A delay of the torques that the axes do not agree on is none."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.stats import t

from flexhex.diagnosis.jointfit import agreement
from flexhex.diagnosis.jointfit.agreement import SURE, axes_agree, few, own_delays
from flexhex.diagnosis.jointfit.fit import calibrate
from flexhex.diagnosis.prepare import Options, run_set_of, spacing_for
from flexhex.diagnosis.regression.calibrate import Calibrated
from flexhex.diagnosis.runs.blocks import blocks
from tests.diagnosis import two_links
from tests.diagnosis.synthetic import plain_csv
from tests.diagnosis.test_payloads_arm import planar

Array = NDArray[np.float64]
__all__ = ["planar"]


def arm(folder: Path, base: str, late: tuple[int, int]) -> Calibrated:
    """The fit of an arm whose torques are logged so many samples late, each axis by itself."""
    paths = []
    for motion, number in ((1, 1), (1, 2), (2, 1), (2, 2)):
        run = two_links.run(motion, number, 0.0, (0.0, 0.0))
        tau = run["tau_meas"]
        run["tau_meas"] = np.stack([np.roll(tau[:, i], late[i]) for i in (0, 1)], axis=1)
        cut = {name: values[20:-20] for name, values in run.items()}
        head = {"trajectory": str(motion), "pass": str(number)}
        paths.append(plain_csv(folder / f"{motion}{number}.csv", cut, **head))
    base_model, run_set, _ = run_set_of(paths, [], None, Options(base=base))
    return calibrate(
        base_model, blocks(base_model, run_set.runs, spacing_for(base_model, run_set.runs))
    )


@pytest.mark.parametrize("late", [(1, 1), (0, 2)])
def test_each_axis_has_a_delay_of_its_own(
    late: tuple[int, int], planar: str, tmp_path: Path
) -> None:
    model = arm(tmp_path, planar, late)
    wanted = two_links.TS * np.array(late)
    np.testing.assert_allclose(own_delays(model), wanted, atol=0.1 * two_links.TS)


@pytest.mark.parametrize(
    ("delays", "agreed"),
    [
        ([0.020, 0.021, 0.019, 0.0205, 0.0199, 0.0201], True),
        ([0.020, 0.021, 0.019, 0.0205, 0.0199, -0.3], True),
        ([0.045, -0.006, 0.010, 0.028, 0.087, 0.067, 0.040], False),
        ([0.001, -0.001, 0.002, -0.002, 0.0], False),
        ([0.045, -0.006], True),
    ],
    ids=["alike", "one is wrong", "apart", "none", "two cannot tell"],
)
def test_delay_is_one_that_most_axes_have(
    delays: list[float], agreed: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(agreement, "own_delays", lambda _: np.array(delays))
    model: Calibrated = None  # type: ignore[assignment]
    assert axes_agree(model) == agreed


@pytest.mark.parametrize("count", [1, 2, 6, 40])
def test_few_values_say_little_of_how_far_they_lie_apart(count: int) -> None:
    """What is `SURE` deviations off is so by Student's distribution, too."""
    far = few(count) * SURE
    assert t.logpdf(0, count) - t.logpdf(far, count) == pytest.approx(SURE**2 / 2)
